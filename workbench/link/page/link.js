// A session with the server over a WebSocket: login, data, control; it comes back by itself, but
// never takes control again by itself.

import { Lease, NEUTRAL } from "./lease.js";
import { Decoder, Flag, Kind, Topic, frameBytes } from "./wire.js";

export const Phase = Object.freeze({
  CONNECTING: "connecting",
  TOKEN: "token", // somebody must type it first
  OPEN: "open",
  WAITING: "waiting", // a pause before the next attempt
});
export const TOPICS = ["position_data", "velocity_data", "drone_state", "lidar_cloud", "events"];

const PREFIX = "/dh_drone/";
const STATE = `${PREFIX}position_data`; // what the pilot acts on
const RATE = 20; // frames a second of each topic, more than an eye needs
const PING = 200; // between pings [ms], so that a link that works is never silent for long
const WATCH = 100; // between looks whether it is [ms]
const LEASE = 0.5; // how long the server's lease lasts, where hello does not say so [s]
const RESTART = 2_000_000_000n; // by which time goes back where a flight begins again, at least [ns]
const SILENCE = 6000; // of a server that answers pings, after which the connection is given up [ms]
const PAUSES = [500, 1000, 2000, 4000, 8000]; // before attempts [ms]
const PATIENT = ["too_many", "back_off", "disconnected"]; // ends that a quick return only repeats
const utf8 = new TextDecoder();
const text = new TextEncoder();

export class Link {
  /**
   * Args:
   *   open: returns a new WebSocket to the server.
   *   listener: has changed() for who flies and how the link is; granted() for control that
   *     begins; sample(name, values, about) for data; said(text) for words that a pilot must see;
   *     token(said) where a token must be typed; wanted() that returns the velocity in W [m/s]
   *     and the yaw rate [rad/s] that the sticks ask for, null while nobody is at them.
   *   name: what this client calls itself.
   *   now: a clock [ms].
   */
  constructor({ open, listener, name, now = () => performance.now() }) {
    Object.assign(this, { open, listener, name, now });
    this.phase = Phase.CONNECTING;
    this.attempts = 0;
    this.credentials = null;
    this.lease = new Lease(this);
    this.reset();
  }

  /** Forget what belonged to the last connection. */
  reset() {
    this.socket = null;
    this.hello = null;
    this.topics = new Map();
    this.role = null;
    this.seq = 0;
    this.nextId = 1;
    this.asked = new Map(); // what was asked, by id
    this.newest = 0n; // time of the newest state, or of the flight as the last pong told it [ns]
    this.heardAt = null;
    this.trip = null; // there and back [ms]
    this.pinged = new Map(); // when, by id
    this.lease.end();
    this.control = null; // the last control_state
    this.silent = false; // whether nothing was heard for longer than a lease lasts
    clearInterval(this.pinging);
    clearInterval(this.watching);
  }

  get flying() {
    return this.lease.number !== 0;
  }

  /** Time since anything was heard, and half the way there and back [ms]; null while unknown. */
  get age() {
    return this.heardAt === null ? null : this.now() - this.heardAt + (this.trip ?? 0) / 2;
  }

  /** Return a topic of the server by its name, undefined if it has none. */
  topic(name) {
    return [...this.topics.values()].find((topic) => topic.name === PREFIX + name);
  }

  /** Connect, now and whenever the connection is lost. */
  start() {
    clearTimeout(this.waiting);
    this.drop();
    this.phase = Phase.CONNECTING;
    const socket = this.open();
    socket.binaryType = "arraybuffer";
    const decoder = new Decoder();
    this.socket = socket;
    this.heardAt = this.now(); // an attempt that nobody answers is given up, too
    this.pinging = setInterval(() => this.ping(), PING);
    this.watchedAt = this.now();
    this.watching = setInterval(() => this.watch(), WATCH);
    socket.onmessage = ({ data }) => this.receive(socket, decoder, data);
    socket.onclose = () => this.closed(socket);
    this.listener.changed();
  }

  /** Log in with a token: { token, role }, role being "command" or "view". */
  logIn(credentials) {
    this.credentials = credentials;
    this.start();
  }

  takeControl() {
    if (this.flying) return;
    if (this.silent) {
      this.listener.said("Could not take control: there is no connection");
      return;
    }
    this.ask({ op: "request_control", name: this.name }, "take control");
  }

  releaseControl() {
    if (!this.flying) return;
    this.neutral();
    this.ask({ op: "release_control", lease: this.lease.number }, "release control");
    this.lease.end();
    this.listener.changed();
  }

  /** Ask for arm, take_off, land or stop. */
  fly(what) {
    const words = what.replace("_", " ");
    if (this.flying) this.ask({ op: "flight", what, lease: this.lease.number }, words);
    else this.listener.said(`Could not ${words}: take control first`);
  }

  /** Send a neutral command at once, as the sticks were let go. */
  neutral() {
    if (this.flying) this.lease.command(NEUTRAL);
  }

  ask(operation, words) {
    if (this.phase !== Phase.OPEN) {
      this.listener.said(`Could not ${words}: there is no connection`);
      return;
    }
    const id = this.nextId++;
    this.asked.set(id, words);
    this.say({ ...operation, id });
  }

  say(operation) {
    this.send({ kind: Kind.CONTROL, payload: text.encode(JSON.stringify(operation)) });
  }

  send(frame) {
    if (this.socket?.readyState === 1) this.socket.send(frameBytes({ seq: ++this.seq, ...frame }));
  }

  ping() {
    const { age } = this;
    if (age !== null && age > SILENCE) {
      this.listener.said("Nothing was heard from the server for 6 s");
      this.closed(this.socket);
      return;
    }
    if (this.phase !== Phase.OPEN) return;
    this.pinged.set(this.nextId, this.now());
    this.say({ op: "ping", id: this.nextId++ });
  }

  /** Notice that the link is silent: the pilot is told before the server's ladder goes on. */
  watch() {
    const now = this.now();
    const late = now - this.watchedAt > 2 * WATCH; // this page stood still: what came waits behind
    this.watchedAt = now;
    if (late || this.silent || this.phase !== Phase.OPEN) return;
    if (now - this.heardAt < 1000 * (this.hello.limits.hold_after ?? LEASE)) return;
    this.silent = true;
    if (this.flying) {
      this.lease.end();
      this.listener.said("You no longer fly: the server is silent, and the drone holds its position");
    }
    this.listener.changed();
  }

  receive(socket, decoder, data) {
    if (socket !== this.socket) return;
    this.heardAt = this.now();
    if (this.silent) {
      this.silent = false;
      this.listener.changed();
    }
    try {
      for (const frame of decoder.feed(new Uint8Array(data))) {
        this.take(frame);
        if (socket !== this.socket) return;
      }
    } catch (error) {
      this.listener.said(`What the server sent cannot be understood: ${error.message}`);
      this.closed(socket);
    }
  }

  take(frame) {
    if (frame.kind === Kind.CONTROL) this.heard(JSON.parse(utf8.decode(frame.payload)));
    if (frame.kind === Kind.DATA) this.sample(frame);
    if (frame.flags & Flag.ACKNOWLEDGE && this.socket?.readyState === 1) {
      this.socket.send(frameBytes({ kind: Kind.ACKNOWLEDGEMENT, seq: frame.seq }));
    }
  }

  sample(frame) {
    const topic = this.topics.get(frame.topic);
    if (!topic) return;
    const { tNs } = frame;
    const anew = tNs < this.newest - RESTART; // the flight began again
    if (topic.name === STATE && (tNs > this.newest || anew)) this.newest = tNs;
    this.listener.sample(topic.name.slice(PREFIX.length), topic.unpack(frame.payload), topic.about);
  }

  heard(operation) {
    const answer = {
      hello: () => this.greet(operation),
      login: () => this.welcome(operation.role),
      request_control: () => this.lease.begin(operation.lease),
      control_state: () => this.told(operation),
      pong: () => this.ponged(operation),
      nack: () => this.refused(operation),
      error: () => this.ended(operation),
      bye: () => this.listener.said(operation.said || "The server stops"),
    }[operation.op];
    if (operation.op !== "nack") this.asked.delete(operation.id);
    answer?.();
  }

  greet(hello) {
    this.hello = hello;
    this.topics = new Map(hello.topics.map((each) => [each.id, new Topic(each)]));
    if (!hello.login) {
      this.say({ op: "login", id: this.nextId++, name: this.name });
      this.welcome("command");
      return;
    }
    if (this.credentials === null) {
      this.wantToken("");
      return;
    }
    const { token, role } = this.credentials;
    this.say({ op: "login", id: this.nextId++, name: this.name, role, token });
  }

  welcome(role) {
    this.role = role;
    this.listener.changed();
    if (this.phase === Phase.OPEN) return;
    this.phase = Phase.OPEN;
    this.attempts = 0;
    const topics = TOPICS.filter((name) => this.topic(name)).map((name) => PREFIX + name);
    this.ask({ op: "subscribe", topics, rate: RATE }, "subscribe");
    this.listener.changed();
  }

  told(state) {
    this.control = state;
    const mine = state.hand === "client" && state.peer === this.hello.peer && state.stage === "live";
    if (this.flying && !mine) {
      this.lease.end();
      this.listener.said(`You no longer fly: ${state.reason}`);
    }
    this.listener.changed();
  }

  ponged({ id, t_ns }) {
    // Far away the states come late: a command on the last of them would be too old.
    if (BigInt(t_ns) > this.newest) this.newest = BigInt(t_ns);
    if (this.pinged.has(id)) this.trip = this.now() - this.pinged.get(id);
    this.pinged.clear();
  }

  refused({ id, seq, code, said }) {
    const words = this.asked.get(id);
    this.asked.delete(id);
    // An answer to a command of an earlier lease says nothing of this one.
    if (code === "not_holder" && !(seq <= this.lease.before)) this.lease.end();
    this.listener.said(words ? `Could not ${words}: ${said}` : said);
    this.listener.changed();
  }

  ended({ code, said }) {
    if (code === "bad_login") {
      this.wantToken(said);
      return;
    }
    if (PATIENT.includes(code)) this.attempts = PAUSES.length;
    this.listener.said(said);
  }

  wantToken(said) {
    this.credentials = null;
    this.drop();
    this.phase = Phase.TOKEN;
    this.listener.token(said);
    this.listener.changed();
  }

  /** Let go of a connection that has ended, or is given up, and try again after a pause. */
  closed(socket) {
    if (socket !== this.socket) return;
    const flew = this.flying;
    this.drop();
    const pause = PAUSES[Math.min(this.attempts++, PAUSES.length - 1)];
    this.phase = Phase.WAITING;
    this.retryAt = this.now() + pause;
    this.waiting = setTimeout(() => this.start(), pause);
    if (flew) this.listener.said("The connection is lost: the drone holds its position");
    this.listener.changed();
  }

  drop() {
    const { socket } = this;
    this.reset();
    if (socket === null) return;
    socket.onmessage = socket.onclose = null;
    socket.close();
  }
}
