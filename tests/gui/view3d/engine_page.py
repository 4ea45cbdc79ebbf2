"""Meshcat's page in the real web engine, asked a few things; prints the answers as JSON.

A process of its own: the web engine wants to be there before the application.
"""

import json
import os
import sys
import time
import traceback

import numpy as np
from pydrake.geometry import Box, Meshcat, MeshcatParams, Rgba
from pydrake.math import RigidTransform, RollPitchYaw
from PyQt6.QtCore import Qt, QUrl
from PyQt6.QtWidgets import QApplication

from workbench.gui.view3d.view3d_panel import PAGE_STATE_SCRIPT, is_blank
from workbench.gui.view3d.web_engine import load_web_view
from workbench.live.picture import DRONE_PATH, place_camera

LIMIT = 120.0
SHAPE = ["drake", "visualizer", "it", "base"]
"""Where the drone's shapes are in Meshcat's tree."""
OPACITY = """(() => { let seen = []; BODY.traverse(each => {
  if (each.material) seen.push(each.material.opacity); }); return seen; })()"""
PLACE = "[...viewer.camera.position.toArray(), ...viewer.controls.target.toArray()]"


class Page:
    """The page, driven by turns of the event loop."""

    def __init__(self) -> None:
        make = load_web_view()
        QApplication.setAttribute(Qt.ApplicationAttribute.AA_ShareOpenGLContexts)
        self.app = QApplication(sys.argv[:1])
        self.meshcat = Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
        self.meshcat.SetObject("box", Box(1, 1, 1), Rgba(1, 0, 0, 1))
        self.meshcat.SetObject("/" + "/".join([*SHAPE, "body"]), Box(1, 1, 1), Rgba(0, 1, 0, 1))
        self.told = 0
        place_camera(self.meshcat, 0.3)
        self.view = make()
        self.view.page().renderProcessTerminated.connect(_ended)
        self.view.resize(300, 300)
        self.view.show()
        self.view.setUrl(QUrl(self.meshcat.web_url()))

    def ask(self, code: str):
        """Return what a line of JavaScript gives, once it is not null."""
        answers, end = [], time.monotonic() + LIMIT
        while True:
            asked = []
            self.view.page().runJavaScript(code, asked.append)
            while not asked:
                assert time.monotonic() < end, f"no answer to {code}: {answers[-1:]}"
                self.app.processEvents()
                time.sleep(0.005)
            answers += asked
            if asked[0] not in (None, ""):
                return asked[0]

    def until(self, reached) -> None:
        """Wait until something is so."""
        end = time.monotonic() + LIMIT
        while not reached():
            assert time.monotonic() < end
            self.app.processEvents()
            time.sleep(0.005)

    def fly(self, place, yaw: float) -> None:
        """Let the drone be at a place, and the page know."""
        pose = RigidTransform(RollPitchYaw(0.0, 0.0, yaw), np.array(place))
        self.meshcat.SetTransform(DRONE_PATH, pose)
        x, y, z = place
        near = f"viewer.controls.target.distanceTo({{x: {x}, y: {z}, z: {-y}}}) < 1e-6"
        self.until(lambda: self.ask(f"String({near})") == "true")

    def tell(self, pose: RigidTransform) -> None:
        """Let the drone be somewhere, and wait until the page has heard of it."""
        self.told += 1
        self.meshcat.SetTransform(DRONE_PATH, pose)
        self.meshcat.SetObject(f"told_{self.told}", Box(1, 1, 1), Rgba(1, 0, 0, 1))
        there = f"viewer.scene_tree.find(['drake']).children.told_{self.told}"
        self.until(lambda: self.ask(f"String(Boolean({there}))") == "true")

    def look(self, way: str) -> list[float]:
        """Return where the camera stands and what it looks at after an order, y up."""
        self.ask(f"window.workbench.look('{way}'); true")
        return self.ask(PLACE)


def _ended(status, code) -> None:
    """Say that the page's process has ended, as where the system has no memory to share."""
    print(json.dumps({"state": {"fault": f"its process ended: {status.name}, {code}"}}), flush=True)
    os._exit(0)


def replay(page: Page) -> dict[str, object]:
    """Return where the camera stands and what is seen while a log is flown, and after it."""
    body = "viewer.scene_tree.find(['replay', 'drone']).object"
    shown = "viewer.scene_tree.find(['replay']).object.visible"
    page.ask(f"window.workbench.log({json.dumps(SHAPE)}, [0, 0, 1, 7, 8, 9]); true")
    columns = RigidTransform(np.array([7.0, 8.0, 9.0])).GetAsMatrix4().T.ravel().tolist()
    page.ask(f"window.workbench.replay({columns}); true")
    found = {
        "replayed": page.ask(PLACE),
        "shown": page.ask(f"String({shown})"),
        "copied": page.ask(f"String({body}.children.length)"),
        "opacity": page.ask(OPACITY.replace("BODY", body)),
        "at": page.ask(f"{body}.position.toArray()"),
    }
    page.tell(RigidTransform(np.array([1.0, 0.0, 1.0])))  # the flight goes on
    found["still"] = page.ask(PLACE)
    page.ask("window.workbench.replay(null); true")
    found["back"], found["hidden"] = page.ask(PLACE), page.ask(f"String({shown})")
    page.ask("window.workbench.look('free'); true")
    page.tell(RigidTransform(np.array([50.0, 0.0, 1.0])))
    found["free"] = page.ask(PLACE)
    return found


def main() -> None:
    """Ask, and print."""
    page = Page()
    state = {}

    def draws() -> bool:
        state.update(json.loads(page.ask(PAGE_STATE_SCRIPT)))
        return state["pictures"] > 0 or bool(state["fault"])

    page.until(draws)
    if state["fault"]:
        print(json.dumps({"state": state}), flush=True)
        os._exit(0)
    page.fly((0.0, 0.0, 1.0), 0.0)
    page.until(lambda: not is_blank(page.view.grab().toImage()))
    found = {"state": json.loads(page.ask(PAGE_STATE_SCRIPT)), "home": page.ask(PLACE)}
    page.fly((30.0, 20.0, 5.0), 0.0)
    found["along"] = page.ask(PLACE)
    for way in ("follow", "top", "side"):
        found[way] = page.look(way)
    page.look("follow")
    page.fly((30.0, 20.0, 5.0), 1.5707963267948966)
    page.until(lambda: page.ask(PLACE)[2] > -19.0)
    found["turned"] = page.ask(PLACE)
    page.ask("viewer.camera.position.set(NaN, NaN, NaN); viewer.controls.target.x = NaN; true")
    found["cured"] = page.look("reset")
    found["controls"] = page.ask("getComputedStyle(viewer.gui.domElement).display")
    found |= replay(page)
    print(json.dumps(found), flush=True)
    os._exit(0)


if __name__ == "__main__":
    try:
        main()
    except BaseException:
        traceback.print_exc()
        os._exit(1)  # to take down a web engine that does not answer may wait for ever
