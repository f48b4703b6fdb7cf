"use strict";
// The line to the server: states come as bytes, the rest as text; wishes go out as text.

const LITTLE = new Uint8Array(new Uint16Array([1]).buffer)[0] === 1;

class Link {
  constructor(onState, onWord, onLine) {
    this.onState = onState, this.onWord = onWord, this.onLine = onLine;
    this.pending = null;
    this.received = 0;
    this.wait = 500;
    this.connect();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/socket`);
    this.socket.binaryType = "arraybuffer";
    this.received = 0;
    this.socket.onopen = () => {
      this.wait = 500;
      this.onLine(true);
    };
    this.socket.onmessage = (event) => {
      if (typeof event.data === "string") this.onWord(JSON.parse(event.data));
      else {
        this.received += 1;
        this.pending = event.data;  // a newer one replaces one that has not been drawn
      }
    };
    this.socket.onclose = () => {
      this.onLine(false);
      setTimeout(() => this.connect(), this.wait);
      this.wait = Math.min(2 * this.wait, 8000);
    };
  }

  // Hand on the newest state, once for each picture, and tell the server that there is room for more.
  take() {
    if (!this.pending) return false;
    const message = this.pending;
    this.pending = null;
    this.onState(decode(message));
    this.send({ do: "got", version: this.received });
    return true;
  }

  send(wish) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(wish));
  }
}

// A state as the server packs it: a head in JSON, then x, y, z and a value of each particle in 16 bits.
function decode(buffer) {
  const view = new DataView(buffer), end = 4 + view.getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, end - 4)));
  if (LITTLE) head.q = new Uint16Array(buffer, end, 4 * head.n);
  else {
    head.q = new Uint16Array(4 * head.n);
    for (let i = 0; i < head.q.length; i++) head.q[i] = view.getUint16(end + 2 * i, true);
  }
  return head;
}
