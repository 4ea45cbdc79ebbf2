// What stands on the page in words and numbers.

import { heading } from "./instruments.js";
import { Phase } from "./link.js";
import { plain } from "./text.js";

const PACES = [0.5, 1, 2, 4]; // speeds to choose from, besides the limit [m/s]
const USUAL = 1;
const SHOWN = 7000; // how long words stay [ms]
const CONFIRM = 4000; // how long Stop waits for the second press [ms]
const TWICE = 300; // a press so soon after the first is the same one [ms]
const LATE = 1000; // of data that no pilot should trust [ms]
const LOW = 0.2; // of the battery
const FLYING = 2; // the first flight mode in the air
const LONGEST_NAME = 48; // of a client that is shown
const find = (id) => document.getElementById(id);

export class Screen {
  constructor() {
    this.mode = null; // not known
    this.limit = 0;
    this.shown = "";
    find("said").querySelector("button").onclick = () => this.hush();
  }

  /** Speed that a stick at its rim asks for [m/s]. */
  get pace() {
    return Number(document.querySelector("[name=pace]:checked")?.value ?? USUAL);
  }

  say(words) {
    clearTimeout(this.hushing);
    const [first, ...rest] = plain(words);
    const text = (first ?? "").toUpperCase() + rest.join("");
    // The same words many times a second would be read aloud as often.
    if (text !== this.shown) find("said").querySelector("p").textContent = text;
    this.shown = text;
    find("said").hidden = false;
    this.hushing = setTimeout(() => this.hush(), SHOWN);
  }

  hush() {
    clearTimeout(this.hushing);
    this.shown = "";
    find("said").hidden = true;
  }

  /** Show how the link is, and who flies. */
  link(link) {
    const [state, words] = connection(link);
    write("connection", words);
    find("connection").dataset.state = state;
    find("instruments").classList.toggle("stale", state !== "open");
    const [who, why] = holder(link);
    write("holder", who);
    write("why", why);
    find("control").dataset.mine = link.flying;
    write("take", link.flying ? "Release" : "Take control");
    for (const button of document.querySelectorAll("#operations button, #take")) {
      const usable = link.flying || (button.id === "take" && hears(link));
      button.setAttribute("aria-disabled", String(!usable));
    }
    for (const pad of document.querySelectorAll(".pad")) {
      pad.setAttribute("aria-disabled", String(!link.flying));
    }
    if (!link.flying) this.forgetStop();
    if (link.hello) this.greet(link.hello);
  }

  greet({ vehicle, limits }) {
    write("vehicle", vehicle);
    document.title = plain(vehicle);
    if (limits.level_speed === this.limit) return;
    this.limit = limits.level_speed;
    const paces = [...PACES.filter((pace) => pace < this.limit), this.limit];
    const chosen = paces.includes(USUAL) ? USUAL : paces[0];
    const labels = paces.map((pace) => {
      const label = document.createElement("label");
      const input = Object.assign(document.createElement("input"), { type: "radio", name: "pace" });
      Object.assign(input, { value: pace, checked: pace === chosen });
      const text = document.createElement("span");
      text.textContent = Number(pace.toPrecision(2));
      text.append(pace === this.limit ? " m/s" : "");
      label.append(input, text);
      return label;
    });
    find("pace").replaceChildren(find("pace").querySelector("legend"), ...labels);
  }

  /** Show how old what is heard is. */
  age(link) {
    const { age } = link;
    const late = age !== null && age > LATE;
    const open = link.phase === Phase.OPEN && age !== null;
    write("age", open ? (late ? (age / 1000).toFixed(1) : age.toFixed(0)) : "–");
    write("age-unit", late ? "s" : "ms");
    warn("age", late);
    if (link.phase === Phase.WAITING) write("connection", connection(link)[1]);
  }

  gauges(place, speed, state) {
    const way = speed ? Math.hypot(speed.v_x, speed.v_y, speed.v_z) : null;
    write("speed", way === null ? "–" : way.toFixed(1));
    write("height", place ? place.z.toFixed(1) : "–");
    write("battery", state ? (100 * state.charge).toFixed(0) : "–");
    warn("battery", state !== undefined && state.charge < LOW);
    this.mode = state?.mode ?? null;
    write("condition", state?.condition ?? "");
  }

  heading(yaw) {
    write("heading", `Heading ${String(heading(yaw)).padStart(3, "0")}°`);
  }

  nearest(words) {
    write("nearest", words);
  }

  /**
   * Return whether Stop may act: in the air the drone falls, so only a second press does it.
   * A drone of which nothing is known may be in the air.
   */
  stopConfirmed() {
    const aground = this.mode !== null && this.mode < FLYING;
    if (!aground && this.forgetting && performance.now() - this.askedAt < TWICE) return false;
    if (aground || this.forgetting) {
      this.forgetStop();
      return true;
    }
    this.askedAt = performance.now();
    write("stop", "Sure?");
    find("stop").classList.add("asking");
    this.say("Stop turns the rotors off, and the drone falls: press again to do it");
    this.forgetting = setTimeout(() => this.forgetStop(), CONFIRM);
    return false;
  }

  forgetStop() {
    clearTimeout(this.forgetting);
    this.forgetting = null;
    write("stop", "Stop");
    find("stop").classList.remove("asking");
  }
}

/** Return how the connection is, as a word for the style sheet and as words to read. */
export function connection(link) {
  if (link.phase === Phase.OPEN && link.silent) return ["lost", "No connection"];
  if (link.phase === Phase.OPEN) return ["open", "Connected"];
  if (link.phase === Phase.TOKEN) return ["waiting", "A token is needed"];
  if (link.phase === Phase.CONNECTING) return ["waiting", "Connecting"];
  const seconds = Math.max(0, (link.retryAt - link.now()) / 1000);
  return ["lost", `Lost: again in ${seconds.toFixed(0)} s`];
}

/** Return whether something is heard of the server. */
function hears(link) {
  return link.phase === Phase.OPEN && !link.silent;
}

/** Return who flies, and why. */
export function holder(link) {
  const { control } = link;
  if (link.silent) return ["You do not fly", "The server is silent"];
  if (link.phase !== Phase.OPEN || control === null) return ["Who flies is not known", ""];
  if (link.flying) return ["You fly", control.reason];
  if (control.hand === "operator") return ["The operator flies", control.reason];
  if (control.hand === "client") {
    const own = control.peer === link.hello.peer;
    const name = own ? "This page" : plain(control.name, LONGEST_NAME) || "Another client";
    const does = own || control.stage !== "live" ? "is silent" : "flies";
    return [`${name} ${does}`, control.reason];
  }
  return ["Nobody flies", control.reason];
}

function write(id, text) {
  const element = find(id);
  const shown = plain(text);
  if (element.textContent !== shown) element.textContent = shown;
}

function warn(id, bad) {
  find(id).closest("div").classList.toggle("bad", bad);
}
