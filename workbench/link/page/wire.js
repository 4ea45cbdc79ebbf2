// Frames as bytes, and topics as their definitions say; see docs/protocol.md.

export const HEADER = 24;
export const VERSION = 1;
export const LARGEST = 64 * 1024;
export const Kind = Object.freeze({ CONTROL: 0, DATA: 1, ACKNOWLEDGEMENT: 2, SKIPPABLE: 0x80 });
export const Flag = Object.freeze({ ACKNOWLEDGE: 2 });

const MAGIC = [0x44, 0x48]; // "DH"

/** What arrived cannot be understood, so the connection must end; `code` is a word. */
export class WireError extends Error {
  constructor(code, said) {
    super(said);
    this.code = code;
  }
}

/** Return a frame as bytes; tNs is a BigInt. */
export function frameBytes({ kind, topic = 0, flags = 0, seq, tNs = 0n, payload = new Uint8Array() }) {
  const bytes = new Uint8Array(HEADER + payload.length);
  const view = new DataView(bytes.buffer);
  bytes.set(MAGIC);
  view.setUint8(2, VERSION);
  view.setUint8(3, kind);
  view.setUint16(4, topic, true);
  view.setUint16(6, flags, true);
  view.setUint32(8, seq, true);
  view.setUint32(12, payload.length, true);
  view.setBigInt64(16, tNs, true);
  bytes.set(payload, HEADER);
  return bytes;
}

/** Takes bytes as they come, in any pieces, and returns whole frames. */
export class Decoder {
  constructor(largest = LARGEST) {
    this.largest = largest;
    this.kept = new Uint8Array();
  }

  /** Yield the frames that are whole now; throws a WireError if what came is no frame. */
  *feed(data) {
    this.kept = joined(this.kept, data);
    let begin = 0;
    try {
      for (;;) {
        checkMagic(this.kept.subarray(begin, begin + MAGIC.length));
        if (this.kept.length - begin < HEADER) return;
        const head = new DataView(this.kept.buffer, this.kept.byteOffset + begin, HEADER);
        const length = head.getUint32(12, true);
        check(head, length, this.largest);
        const end = begin + HEADER + length;
        if (this.kept.length < end) return;
        const frame = {
          kind: head.getUint8(3),
          topic: head.getUint16(4, true),
          flags: head.getUint16(6, true),
          seq: head.getUint32(8, true),
          tNs: head.getBigInt64(16, true),
          payload: this.kept.slice(begin + HEADER, end),
        };
        begin = end;
        yield frame;
      }
    } finally {
      this.kept = this.kept.slice(begin);
    }
  }
}

function joined(one, other) {
  if (!one.length) return other;
  const all = new Uint8Array(one.length + other.length);
  all.set(one);
  all.set(other, one.length);
  return all;
}

/** Refuse what begins otherwise, with the first byte that does. */
function checkMagic(found) {
  if (found.some((byte, i) => byte !== MAGIC[i])) {
    throw new WireError("magic", "a frame must begin with DH");
  }
}

function check(head, length, largest) {
  const version = head.getUint8(2);
  if (version !== VERSION) throw new WireError("version", `a frame has version ${version}`);
  const kind = head.getUint8(3);
  if (kind > Kind.ACKNOWLEDGEMENT && !(kind & Kind.SKIPPABLE)) {
    throw new WireError("kind", `frames of kind ${kind} are unknown`);
  }
  if (length > largest) throw new WireError("length", `a frame of ${length} bytes is too long`);
}

const NUMBERS = {
  float32: [4, (view, at) => view.getFloat32(at, true), (view, at, x) => view.setFloat32(at, x, true)],
  float64: [8, (view, at) => view.getFloat64(at, true), (view, at, x) => view.setFloat64(at, x, true)],
  int32: [4, (view, at) => view.getInt32(at, true), (view, at, x) => view.setInt32(at, x, true)],
  uint32: [4, (view, at) => view.getUint32(at, true), (view, at, x) => view.setUint32(at, x, true)],
  int64: [8, (view, at) => view.getBigInt64(at, true), (view, at, x) => view.setBigInt64(at, BigInt(x), true)],
};

/** What a frame of data carries, made of a definition in HELLO. */
export class Topic {
  constructor(definition) {
    this.id = definition.id;
    this.name = definition.name;
    this.rate = definition.rate;
    this.about = definition.about;
    this.fields = definition.fields;
    this.size = this.fields.reduce((sum, field) => sum + sizeOf(field), 0);
  }

  /** Return the fields by name: numbers, texts, int64 as BigInt, several numbers as an array. */
  unpack(payload) {
    if (payload.length !== this.size) {
      throw new WireError("size", `${this.name} has ${this.size} bytes, not ${payload.length}`);
    }
    const view = new DataView(payload.buffer, payload.byteOffset, payload.length);
    const values = {};
    let at = 0;
    for (const field of this.fields) {
      values[field.name] = read(field, view, at);
      at += sizeOf(field);
    }
    return values;
  }

  /** Return the payload of numbers by name; those that are not given are 0. */
  pack(values) {
    const bytes = new Uint8Array(this.size);
    const view = new DataView(bytes.buffer);
    let at = 0;
    for (const field of this.fields) {
      NUMBERS[field.type][2](view, at, values[field.name] ?? 0);
      at += sizeOf(field);
    }
    return bytes;
  }
}

function sizeOf(field) {
  return field.type === "char" ? field.count : field.count * NUMBERS[field.type][0];
}

function read(field, view, at) {
  if (field.type === "char") {
    const bytes = new Uint8Array(view.buffer, view.byteOffset + at, field.count);
    return new TextDecoder().decode(bytes).replace(/\0+$/, "");
  }
  const [size, get] = NUMBERS[field.type];
  if (field.count === 1) return get(view, at);
  return Array.from({ length: field.count }, (_, i) => get(view, at + i * size));
}
