/** The way to the server: one change after another, always the newest, never two at once. */

/**
 * Sends what was typed, a moment after the last change. While an answer is awaited further changes
 * gather, so that the session never takes an older value over a newer one.
 */
export class Sender {
  #url;
  #token;
  #wait;
  #gathered = {};
  #timer = 0;
  #busy = false;
  #heard;

  /**
   * @param {string} url
   * @param {string} token that says that the page is ours
   * @param {(answer: {status: number, document: object|null}, sent: object) => Promise<void>} heard
   *     what to do with an answer; status 0 where there was none
   * @param {number} wait milliseconds
   */
  constructor(url, token, heard, wait = 250) {
    this.#url = url;
    this.#token = token;
    this.#heard = heard;
    this.#wait = wait;
  }

  /** Something was typed for a measurement. */
  change(name, text) {
    this.#gathered[name] = text;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#send(), this.#wait);
  }

  async #send() {
    if (this.#busy || !Object.keys(this.#gathered).length) return;
    this.#busy = true;
    const sent = this.#gathered;
    this.#gathered = {};
    try {
      await this.#heard(await this.#ask(sent), sent);
    } finally {
      this.#busy = false;
    }
    this.#send();
  }

  async #ask(answers) {
    try {
      const response = await fetch(this.#url, {
        method: "POST",
        headers: { "Content-Type": "application/json", "X-CSRFToken": this.#token },
        body: JSON.stringify(answers),
      });
      const json = /json/.test(response.headers.get("Content-Type") ?? "");
      return { status: response.status, document: json ? await response.json() : null };
    } catch {
      return { status: 0, document: null };
    }
  }
}
