// Runs in Meshcat's page before anything of it: tells whether it draws, lowers the cost where the
// processor draws, moves the camera, and shows a log beside the flight, which costs that nothing.
// The page's own `viewer` is Meshcat's.
"use strict";

window.workbench = (() => {
  const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;
  const SOFTWARE_PERIOD = 1000 / 15; // between two pictures [ms]
  const SOFTWARE_RATIO = 1; // pixels drawn for each of the page, along one side
  const DRONE = "/drone";
  const REPLAY = ["replay", "drone"], WAY = ["replay", "way"];
  const REPLAY_OPACITY = 0.5, REPLAY_COLOUR = 0xd08020;
  const BACKGROUND = ["Background", "<object>"];
  const CAMERA = "/Cameras/default";
  // From the drone to the camera, of length 1; y up, as three.js has it; seen at heading 0.
  const FOLLOW = [-0.94, 0.34, 0];
  const TOP = [0, 1, 0.001];
  const SIDE = [0, 0.1, 0.995];

  let fault = "", software = false, turns = false, free = false, yaw = 0;
  let place = null; // of the drone that the camera follows
  let flown = null; // the flight's last transform, while a log is shown
  let replayed = false, shape = null, copied = 0;
  let home = [-0.75, 0.37, 0.55], distance = 2; // of the camera, as the flight says

  function probe() {
    const context = document.createElement("canvas").getContext("webgl2");
    if (!context) {
      fault = "webgl";
      return;
    }
    const info = context.getExtension("WEBGL_debug_renderer_info");
    const name = info ? context.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
    software = SOFTWARE.test(name);
    const lose = context.getExtension("WEBGL_lose_context");
    if (lose) lose.loseContext();
  }

  function lighten() {
    const original = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, attributes) {
      return original.call(this, kind, { ...attributes, antialias: false });
    };
  }

  // three.js turns z up into y up
  const upright = (x, y, z) => [x, z, -y];

  function stand(direction, far) {
    const [x, y, z] = direction;
    const [cosine, sine] = turns ? [Math.cos(yaw), Math.sin(yaw)] : [1, 0];
    const [p, q, r] = place || [0, 0, 0];
    viewer.controls.target.set(p, q, r);
    viewer.camera.position.set(
      p + far * (cosine * x + sine * z), q + far * y, r + far * (cosine * z - sine * x));
    viewer.camera.zoom = 1;
    viewer.set_dirty();
  }

  // The camera keeps its way from the drone, which the mouse may have changed.
  function move(matrix) {
    const next = upright(matrix[12], matrix[13], matrix[14]);
    const heading = Math.atan2(matrix[1], matrix[0]);
    const turned = turns ? heading - yaw : 0;
    const first = !place;
    const before = place || next;
    place = next;
    yaw = heading;
    if (first) {
      stand(home, distance);
      return;
    }
    if (free) return;
    const { position } = viewer.camera, { target } = viewer.controls;
    const x = position.x - before[0], z = position.z - before[2];
    const cosine = Math.cos(turned), sine = Math.sin(turned);
    position.set(
      next[0] + cosine * x + sine * z, position.y + next[1] - before[1],
      next[2] + cosine * z - sine * x);
    target.set(
      target.x + next[0] - before[0], target.y + next[1] - before[1],
      target.z + next[2] - before[2]);
  }

  // What the flight says of the camera is for pages without this script.
  function command(original, told) {
    if (told.type === "set_transform" && told.path === DRONE) {
      flown = told.matrix;
      if (!replayed) move(flown);
      viewer.set_dirty();
    } else if (told.type === "set_property" && told.path.startsWith(CAMERA)
               && told.property === "position") {
      distance = Math.hypot(...told.value);
      home = told.value.map(each => each / distance);
      if (place) stand(home, distance);
    } else if (told.type !== "set_target"
               && !(told.type === "set_transform" && told.path === CAMERA)) {
      original(told);
    }
  }

  const object = path => viewer.scene_tree.find(path).object;

  const meshes = body => {
    let count = 0;
    body.traverse(each => { count += each.material ? 1 : 0; });
    return count;
  };

  // A pale copy of the drone; once more when more of it is loaded.
  function copy() {
    const count = meshes(object(shape));
    if (count === copied) return;
    copied = count;
    const body = object(REPLAY);
    body.clear();
    for (const child of object(shape).children) body.add(child.clone(true));
    body.traverse(each => {
      if (!each.material) return;
      const pale = kind => Object.assign(
        kind.clone(), { transparent: true, opacity: REPLAY_OPACITY });
      each.material = Array.isArray(each.material) ? each.material.map(pale) : pale(each.material);
    });
  }

  function draw_way(points) {
    const { BufferGeometry, Float32BufferAttribute, Line, LineBasicMaterial } = MeshCat.THREE;
    const group = object(WAY);
    for (const old of group.children) old.geometry.dispose();
    group.clear();
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
    group.add(new Line(geometry, new LineBasicMaterial({ color: REPLAY_COLOUR })));
  }

  function begin() {
    if (typeof viewer === "undefined") {
      fault = fault || "webgl";
      return;
    }
    const original = viewer.handle_command.bind(viewer);
    viewer.handle_command = told => command(original, told);
    viewer.gui.hide(); // Meshcat's own controls cover the picture; a browser's page has them
    viewer.renderer.domElement.addEventListener("webglcontextlost", () => { fault = "lost"; });
    if (!software) return;
    viewer.renderer.setPixelRatio(SOFTWARE_RATIO);
    viewer.renderer.shadowMap.enabled = false;
    const render = viewer.render.bind(viewer);
    let last = -Infinity;
    viewer.render = () => { // what is not drawn now is drawn with one of the next frames
      const now = performance.now();
      if (now - last < SOFTWARE_PERIOD) return;
      last = now;
      render();
    };
  }

  probe();
  if (software) lighten();
  document.addEventListener("DOMContentLoaded", begin);
  return {
    state: () => JSON.stringify({
      fault, software, connected: place !== null,
      pictures: typeof viewer === "undefined" ? 0 : viewer.renderer.info.render.frame,
    }),
    look: way => {
      turns = way === "follow";
      free = way === "free";
      if (free) return;
      const ways = { follow: [FOLLOW, 1], top: [TOP, 3], side: [SIDE, 1.2], reset: [home, 1] };
      const [direction, times] = ways[way];
      stand(direction, times * distance);
    },
    background: (top, bottom) => {
      viewer.set_property(BACKGROUND, "top_color", top);
      viewer.set_property(BACKGROUND, "bottom_color", bottom);
    },
    show: (path, shown) => viewer.set_property([path], "visible", shown),
    // A log: the drone's path in Meshcat's tree, and x, y, z of the places flown one after another.
    log: (path, points) => {
      [shape, copied] = [path, -1];
      draw_way(points);
    },
    // Its drone: a transform by columns, or null for none any more.
    replay: matrix => {
      replayed = matrix !== null;
      viewer.set_property(["replay"], "visible", replayed);
      if (replayed) {
        copy();
        viewer.set_transform(REPLAY, matrix);
        move(matrix);
      } else if (flown) {
        move(flown);
      }
      viewer.set_dirty();
    },
  };
})();
