/** The way from an address to a body as numbers. */

import { readGlb } from "./glb.js";

export class ViewerError extends Error {}

/**
 * @param {string|Request} url
 * @param {AbortSignal} signal that stops the download
 * @returns {Promise<ReturnType<typeof readGlb>>}
 * @throws {ViewerError} where there is no file, or no avatar in it
 */
export async function fetchBody(url, signal) {
  try {
    const response = await fetch(url, { signal });
    if (!response.ok) throw new ViewerError(`The avatar's file: status ${response.status}.`);
    return readGlb(await response.arrayBuffer());
  } catch (error) {
    if (error instanceof ViewerError) throw error;
    throw new ViewerError("The avatar's file could not be shown.", { cause: error });
  }
}
