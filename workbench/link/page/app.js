// The page: what the link says goes to the screen, what fingers do goes to the link.

import { Attitude, Ring, nearestWords } from "./instruments.js";
import { NEUTRAL } from "./lease.js";
import { Link, Phase } from "./link.js";
import { Scan } from "./scan.js";
import { Screen } from "./screen.js";
import { Stick, velocity } from "./sticks.js";
import { Tokens } from "./tokens.js";

const SLOWEST_PICTURE = 250; // between pictures where nothing comes [ms]

const find = (id) => document.getElementById(id);
const stick = (id) => new Stick(find(id).querySelector(".pad"), find(id).querySelector(".knob"));

class App {
  constructor() {
    this.screen = new Screen();
    this.tokens = new Tokens((credentials) => this.link.logIn(credentials));
    this.attitude = new Attitude(find("attitude"));
    this.ring = new Ring(find("ring"));
    this.left = stick("left");
    this.right = stick("right");
    this.values = {}; // the newest of each topic
    this.scan = null;
    this.fresh = false;
    this.link = new Link({
      open: () => new WebSocket(new URL("ws", location.href.replace(/^http/, "ws"))),
      listener: this,
      name: navigator.maxTouchPoints > 0 ? "phone" : "browser",
    });
    this.link.credentials = this.tokens.kept();
    this.listen();
    this.link.start();
    setInterval(() => this.picture(), SLOWEST_PICTURE);
  }

  listen() {
    find("take").onclick = () => {
      if (this.link.flying) this.link.releaseControl();
      else this.link.takeControl();
    };
    for (const button of document.querySelectorAll("[data-what]")) {
      button.onclick = () => this.link.fly(button.dataset.what);
    }
    find("hold").onclick = () => {
      this.letGo();
      this.link.fly("hold"); // ends a take-off or a landing, too
    };
    find("stop").onclick = () => {
      if (!this.link.flying || this.screen.stopConfirmed()) this.link.fly("stop");
    };
    addEventListener("blur", () => this.letGo());
    addEventListener("pagehide", () => this.letGo());
    document.addEventListener("visibilitychange", () => document.hidden && this.letGo());
  }

  /** Spring both sticks back, and say so to the drone at once. */
  letGo() {
    this.left.release();
    this.right.release();
    this.link.neutral();
  }

  // What the link calls.

  changed() {
    this.screen.link(this.link);
    if (this.link.phase !== Phase.OPEN) this.values = {};
    if (this.link.phase === Phase.OPEN) this.tokens.close();
    this.fresh = true;
  }

  granted() {
    // A finger that is down already counts only when it comes again.
    this.left.release();
    this.right.release();
  }

  said(text) {
    this.screen.say(text);
  }

  token(said) {
    this.tokens.ask(said);
  }

  sample(name, values, about) {
    if (name === "events") {
      if (values.severity > 0) this.said(values.said);
      return;
    }
    this.values[name] = { ...values, about };
    if (!this.fresh) requestAnimationFrame(() => this.picture());
    this.fresh = true;
  }

  wanted() {
    if (document.hidden) return null;
    const place = this.values.position_data;
    if (!place) return NEUTRAL;
    const { left, right } = this;
    const { limits } = this.link.hello;
    return velocity(left.value, right.value, place.yaw, this.screen.pace, limits);
  }

  picture() {
    this.screen.age(this.link);
    if (!this.fresh) return;
    this.fresh = false;
    const { position_data: place, velocity_data: speed, drone_state: state } = this.values;
    this.screen.gauges(place, speed, state);
    if (!place) return;
    this.attitude.show(place.roll, place.pitch, place.yaw);
    this.screen.heading(place.yaw);
    this.obstacles(place);
  }

  obstacles(place) {
    const cloud = this.values.lidar_cloud;
    if (!cloud) {
      this.screen.nearest(this.link.topic("lidar_cloud") ? "No scan yet" : "No lidar");
      return;
    }
    if (cloud === this.shownCloud) return;
    this.shownCloud = cloud;
    if (this.scan?.about !== cloud.about) this.scan = new Scan(cloud.about);
    const nearest = this.scan.nearest(cloud.ranges, place.roll, place.pitch, place.z);
    this.ring.show(nearest);
    this.screen.nearest(nearestWords(nearest));
  }
}

new App();
