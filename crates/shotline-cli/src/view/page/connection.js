// The conversation with the program: a question at a time, so that it never has more work than one step.

class Connection {
  constructor(onNews, onEnd) {
    this.waiting = new Map();
    this.queue = [];
    this.isBusy = false;
    this.lastId = 0;
    this.idle = () => null;
    this.isOpen = false;
    const address = new URL("socket", location.href);
    address.protocol = "ws:";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => { this.isOpen = true; this.next(); };
    this.socket.onclose = () => { this.isOpen = false; onEnd(); };
    this.socket.onmessage = ({ data }) => {
      const answer = typeof data === "string" ? { head: JSON.parse(data) } : unpacked(data);
      if (answer.head.news) { onNews(answer.head); return; }
      this.isBusy = false;
      const waiting = this.waiting.get(answer.head.id);
      this.waiting.delete(answer.head.id);
      if (waiting) {
        if (answer.head.error) waiting.reject(new Error(answer.head.error));
        else waiting.resolve(answer);
      }
      this.next();
    };
  }

  // Asks, before any picture goes on.
  ask(question) {
    return new Promise((resolve, reject) => {
      this.queue.push({ question, resolve, reject });
      this.next();
    });
  }

  // What is to be drawn while nothing is asked: `idle` returns a question and who takes the answer, or null.
  next() {
    if (this.isBusy || !this.isOpen) return;
    const entry = this.queue.shift() ?? this.idle();
    if (!entry) return;
    this.isBusy = true;
    this.lastId += 1;
    this.waiting.set(this.lastId, entry);
    this.socket.send(JSON.stringify({ id: this.lastId, ...entry.question }));
  }
}

// A head and bytes: the length of the head comes first.
function unpacked(data) {
  const size = new DataView(data).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, size)));
  return { head, bytes: new Uint8ClampedArray(data, 4 + size) };
}
