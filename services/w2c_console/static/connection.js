// @ts-check
/** A WebSocket that comes back by itself. */

const FIRST_RETRY_MS = 200;
const LONGEST_RETRY_MS = 2000;
/** The server says something at least once a second; a longer silence is a dead link. */
const SILENCE_MS = 4000;

export class Connection {
  /**
   * @param {string} path
   * @param {{
   *   greet: (send: (text: string) => void) => void,
   *   receive: (data: any, send: (text: string) => void) => void,
   *   change: (open: boolean) => void,
   * }} handlers `greet` speaks first; `change` tells whether the other side is heard
   */
  constructor(path, handlers) {
    this.url = new URL(path, location.href.replace(/^http/, "ws")).href;
    this.handlers = handlers;
    this.retryMs = FIRST_RETRY_MS;
    this.open();
  }

  open() {
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    let ended = false;
    let watchdog = 0;
    const send = (/** @type {string} */ text) => {
      if (socket.readyState === WebSocket.OPEN) socket.send(text);
    };
    const end = () => {
      if (ended) return;
      ended = true;
      clearTimeout(watchdog);
      socket.close();
      this.handlers.change(false);
      setTimeout(() => this.open(), this.retryMs);
      this.retryMs = Math.min(this.retryMs * 2, LONGEST_RETRY_MS);
    };
    const heard = () => {
      clearTimeout(watchdog);
      watchdog = setTimeout(end, SILENCE_MS);
    };
    heard();
    socket.onopen = () => this.handlers.greet(send);
    socket.onclose = end;
    socket.onmessage = (event) => {
      if (ended) return;
      heard();
      this.retryMs = FIRST_RETRY_MS;
      this.handlers.change(true);
      this.handlers.receive(event.data, send);
    };
  }
}
