/** The page's end of the worker that finds people in pictures. */

/** Whether this browser has what the network needs: WebAssembly, and WebGL 2 in a worker. */
export function canFind() {
  if (!globalThis.Worker || !globalThis.WebAssembly || !globalThis.OffscreenCanvas) return false;
  try {
    return Boolean(new OffscreenCanvas(1, 1).getContext("webgl2"));
  } catch {
    return false;
  }
}

/**
 * A finder of people.
 *
 * @param {{worker: string, loader: string, binary: string, model: string}} places addresses on
 *   this site
 */
export function createFinder(places) {
  const worker = new Worker(places.worker, { type: "module" });
  const waiting = new Map();
  let last = 0;

  worker.addEventListener("message", ({ data: { id, error, ...answer } }) => {
    const { resolve, reject } = waiting.get(id);
    waiting.delete(id);
    if (error) reject(new Error(error));
    else resolve(answer);
  });
  worker.addEventListener("error", (event) => fail(new Error(event.message || "no worker")));

  function fail(error) {
    for (const { reject } of waiting.values()) reject(error);
    waiting.clear();
  }

  function ask(task, about, transfer = []) {
    last += 1;
    const id = last;
    return new Promise((resolve, reject) => {
      waiting.set(id, { resolve, reject });
      worker.postMessage({ id, task, ...about }, transfer);
    });
  }

  const { loader, binary, model } = places;
  return {
    /** Settled when the network is there. */
    ready: ask("start", { loader, binary, model }),
    /** The outline in a photo: `{people, agreement, width, height, data}`; data null for nobody. */
    async outline(photo) {
      const picture = await createImageBitmap(photo);
      return ask("outline", { picture }, [picture]);
    },
    /** The people in a picture of the camera: `{people}`. The picture is used up. */
    watch: (frame, time) => ask("watch", { frame, time }, [frame]),
    /** The end of it; who still waits is told. */
    stop() {
      worker.terminate();
      fail(new Error("the finder was stopped"));
    },
  };
}
