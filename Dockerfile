# The site in three stages: the front end, the Python packages, and what runs.
#
#     docker build -t fitting-room . && docker run -p 8000:8000 -e SECRET_KEY=… fitting-room

FROM node:22-slim AS front
WORKDIR /site
COPY package.json package-lock.json .npmrc ./
# With the optional packages: one of them is esbuild's program for this machine.
RUN npm ci --no-audit --no-fund
COPY scripts/build.mjs scripts/pose_bundle.mjs scripts/
COPY static static
RUN npm run --silent build

FROM python:3.13-slim AS packages
WORKDIR /site
COPY requirements.txt .
# Each has a wheel for these machines: nothing is compiled.
RUN python -m venv /venv \
    && /venv/bin/pip install --no-cache-dir --no-deps --require-hashes --only-binary :all: -r requirements.txt

FROM python:3.13-slim
WORKDIR /site
COPY Aptfile .
RUN apt-get update && xargs apt-get install -y --no-install-recommends <Aptfile \
    && rm -rf /var/lib/apt/lists/* Aptfile \
    && useradd --system --no-create-home --uid 10001 site
COPY --from=packages /venv /venv
COPY LICENSE NOTICE ./
COPY model model
COPY webapp webapp
COPY templates templates
COPY --from=front /site/static static
ENV PATH=/venv/bin:$PATH PYTHONDONTWRITEBYTECODE=1 PYTHONUNBUFFERED=1
# By its number: who forbids root by a rule need not look the name up.
USER 10001
EXPOSE 8000
HEALTHCHECK --interval=15s --timeout=5s --start-period=30s CMD ["python", "-c", \
    "import os, urllib.request as r; r.urlopen(f'http://127.0.0.1:{os.environ.get(\"PORT\") or 8000}/healthz', timeout=4)"]
CMD ["gunicorn", "--config", "webapp/server.py", "webapp:create_app()"]
