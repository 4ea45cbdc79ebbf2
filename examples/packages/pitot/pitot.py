"""A pitot tube: the speed of the air along the x axis of its frame."""

from dataclasses import dataclass

import numpy as np

from workbench.common.parameter import Parameter
from workbench.link.signal import STAMP_FIELD, Signal
from workbench.link.topics import Field
from workbench.plant.noise_reader import read_noise
from workbench.plant.sensors import NO_NOISE, Noise
from workbench.systems.sensors.measuring import MeasuringSensor, SensorInstrument
from workbench.systems.sensors.mounting import sensor_motion
from workbench.systems.sensors.readings import Reading


@dataclass(frozen=True)
class AirspeedReading(Reading):
    """A sample [m/s]."""

    airspeed: float


@dataclass(frozen=True)
class Pitot(MeasuringSensor):
    """The tube; its noise is that of the speed [m/s]."""

    kind = "airspeed"
    usual_rate = 50.0
    types = ("air_speed",)
    parameters = (
        Parameter("airspeed_blocked", "1", "blocked share of the tube", 0.0, 1.0, 0.0, "airspeed"),
    )
    noise_unit = "m/s"

    noise: Noise = NO_NOISE

    @classmethod
    def read(cls, common, block, remarks):
        """Return the tube of a <sensor> block."""
        return cls(**vars(common), noise=read_noise(block.block("air_speed"), remarks))

    def instrument(self, site):
        """Return what it measures."""
        p_BS, x_B = np.array(self.p_BS), np.array(self.R_BS)[:, 0]

        def exact(inputs, settings):
            moves = sensor_motion(inputs["state"], p_BS)
            speed = (moves.R_WB @ x_B) @ (moves.v_WS - inputs["wind"])
            return np.array([(1.0 - settings[0]) * speed])

        return SensorInstrument(
            columns=("airspeed [m/s]",),
            usual=(0.5,),
            noises=[self.noise],
            inputs={"state": 13, "wind": 3},
            exact=exact,
            reading=lambda stamp, values: AirspeedReading(stamp, self.frame, *values),
            settings=(0.0,),
        )


AIRSPEED = Signal(
    id=1001,
    name="airspeed",
    title="Airspeed",
    rate="airspeed",
    fields=(STAMP_FIELD, Field("airspeed", "float32", "m/s", "S")),
    own_type="Airspeed",
)
