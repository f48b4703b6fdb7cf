// The connection to the server: states come as bytes, messages as text; commands go out as text.

/** @import { Command } from "./commands.js" */
/** @import { Message, StateHead } from "./protocol.js" */
/** @import { State } from "./draw/snow_cloud.js" */

const IS_LITTLE_ENDIAN = new Uint8Array(new Uint16Array([1]).buffer)[0] === 1;
const FIRST_WAIT = 500; // ms until the first attempt to connect again

export class Connection {
  /**
   * @param {object} handlers
   * @param {(state: State) => void} handlers.onState
   * @param {(message: Message) => void} handlers.onMessage
   * @param {(open: boolean) => void} handlers.onOpen called when it opens and when it is lost
   */
  constructor({ onState, onMessage, onOpen }) {
    this.onState = onState;
    this.onMessage = onMessage;
    this.onOpen = onOpen;
    /** @type {ArrayBuffer | null} the newest state that has not been drawn */
    this.pending = null;
    this.received = 0;
    this.wait = FIRST_WAIT;
    this.socket = this.connect();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/socket`);
    socket.binaryType = "arraybuffer";
    this.received = 0;
    socket.onopen = () => {
      this.wait = FIRST_WAIT;
      this.onOpen(true);
    };
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") this.onMessage(JSON.parse(data));
      else {
        this.received += 1;
        this.pending = data;
      }
    };
    socket.onclose = () => {
      this.onOpen(false);
      setTimeout(() => (this.socket = this.connect()), this.wait);
      this.wait = Math.min(2 * this.wait, 8000);
    };
    return socket;
  }

  /**
   * Hand on the newest state, once for each picture, and tell the server that there is room for more.
   * @returns {boolean} whether there was one
   */
  take() {
    if (!this.pending) return false;
    const bytes = this.pending;
    this.pending = null;
    this.onState(decode(bytes));
    this.send({ do: "acknowledge", version: this.received });
    return true;
  }

  /** @param {Command} command */
  send(command) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(command));
  }
}

/**
 * Read a state: the length of its head, the head in JSON, then x, y, z and a value of each particle in 16 bits.
 * @param {ArrayBuffer} buffer
 * @returns {State}
 */
function decode(buffer) {
  const view = new DataView(buffer);
  const end = 4 + view.getUint32(0, true);
  /** @type {StateHead} */
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, end - 4)));
  if (IS_LITTLE_ENDIAN) return { ...head, q: new Uint16Array(buffer, end, 4 * head.n) };
  const q = new Uint16Array(4 * head.n);
  for (let i = 0; i < q.length; i++) q[i] = view.getUint16(end + 2 * i, true);
  return { ...head, q };
}
