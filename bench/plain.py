"""A plain page, to compare the site with: what Flask and the server take by themselves."""

from flask import Flask

app = Flask(__name__)


@app.get("/")
@app.get("/healthz")
def page() -> str:
    """Some words."""
    return "<!doctype html><title>Plain</title><p>" + "A plain page. " * 200
