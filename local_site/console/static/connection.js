// The one WebSocket to the console: reopened when it is lost; messages that could not be sent are not queued.
/** @import { Messages, PageMessage, Request } from "../model/messages.d.ts" */

const AGAIN_MS = 500;
const MOST_WAITING = 65536;

export class Connection {
  /** @type {(message: Messages[keyof Messages]) => void} */
  onText = () => {};
  /** @type {(bytes: ArrayBuffer) => void} */
  onPicture = () => {};
  /** @type {(open: boolean) => void} */
  onChange = () => {};
  /** @type {WebSocket | null} */
  #socket = null;
  #numbers = 0;

  open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/page`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.onChange(true);
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.onText(JSON.parse(data)) : this.onPicture(data));
    socket.onclose = () => {
      this.onChange(false);
      setTimeout(() => this.open(), AGAIN_MS);
    };
    this.#socket = socket;
  }

  /** Send a message now; false when there is no connection that would take it immediately.
   * @type {(message: PageMessage) => boolean} */
  send(message) {
    const socket = this.#socket;
    if (socket === null || socket.readyState !== WebSocket.OPEN || socket.bufferedAmount > MOST_WAITING) return false;
    socket.send(JSON.stringify(message));
    return true;
  }

  /** Send a request; its number, or null without a connection.
   * @type {(message: Request) => number | null} */
  ask(message) {
    const id = ++this.#numbers;
    return this.send({ ...message, id }) ? id : null;
  }
}
