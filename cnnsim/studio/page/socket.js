// A model for the view over the websocket of the studio's server.

/** @typedef {import("./base.js").Content} Content */

/** A message is JSON, or with buffers: length of the JSON (4 bytes, little-endian), JSON, buffers. */
export class SocketModel {
  /** @param {() => void} opened @param {(reason: string) => void} closed */
  constructor(opened, closed) {
    /** @type {((content: Content, buffers: Uint8Array[]) => void)[]} */
    this.calls = [];
    this.socket = new WebSocket(`ws://${location.host}/ws`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = opened;
    this.socket.onclose = (event) => closed(event.reason);
    this.socket.onmessage = (event) => this.receive(event.data);
  }

  /** @param {string} _event @param {(content: Content, buffers: Uint8Array[]) => void} call */
  on(_event, call) {
    this.calls.push(call);
  }

  /** @param {string | ArrayBuffer} data */
  receive(data) {
    let text = data, buffers = /** @type {Uint8Array[]} */ ([]);
    if (data instanceof ArrayBuffer) {
      const length = new DataView(data).getUint32(0, true);
      text = new TextDecoder().decode(new Uint8Array(data, 4, length));
      let begin = 4 + length;
      for (const size of JSON.parse(text).sizes) {
        buffers.push(new Uint8Array(data, begin, size));
        begin += size;
      }
    }
    const content = JSON.parse(/** @type {string} */ (text));
    for (const call of this.calls) call(content, buffers);
  }

  /** @param {Content} content @param {any} [_callbacks] @param {Uint8Array[]} [buffers] */
  send(content, _callbacks, buffers = []) {
    if (!buffers.length) {
      this.socket.send(JSON.stringify(content));
      return;
    }
    const head = new TextEncoder().encode(JSON.stringify({ ...content, sizes: buffers.map((b) => b.length) }));
    const whole = new Uint8Array(4 + head.length + buffers.reduce((sum, b) => sum + b.length, 0));
    new DataView(whole.buffer).setUint32(0, head.length, true);
    whole.set(head, 4);
    let begin = 4 + head.length;
    for (const buffer of buffers) {
      whole.set(buffer, begin);
      begin += buffer.length;
    }
    this.socket.send(whole);
  }
}
