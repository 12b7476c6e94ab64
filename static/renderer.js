/**
 * A worker that says whether a graphics processor draws in 3D. Where none does, the first drawing
 * takes seconds, and even to ask takes a while, in which a page that asked itself would stand still.
 */

const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i; // renderers by their names

function drawsFast() {
  if (!globalThis.OffscreenCanvas) return false;
  const context = new OffscreenCanvas(1, 1).getContext("webgl2", { failIfMajorPerformanceCaveat: true });
  if (!context) return false;
  // Some browsers name a software renderer but do not hold it for a caveat.
  const info = context.getExtension("WEBGL_debug_renderer_info");
  return !SOFTWARE.test(context.getParameter(info?.UNMASKED_RENDERER_WEBGL ?? context.RENDERER));
}

postMessage(drawsFast());
