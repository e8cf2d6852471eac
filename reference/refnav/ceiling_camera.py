"""CeilingCamera: takes pictures of the ceiling above a simulated base."""

from __future__ import annotations

from random import Random

from refnav.ceiling import BRIGHT, View, parse, picture
from refnav.map_text import MapError, text_of
from refnav.messages import pose_of
from refrobots import rtc
from refrobots.components.ceiling_camera import CeilingCameraBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class CeilingCamera(CeilingCameraBase):
    """One picture for each execution, once the pose of the base is known."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Load the lamps."""
        name = self.config.ceiling_map
        try:
            self._lamps = parse(text_of(self.folder, name), name)
        except MapError as error:
            return self.fail(f"ceiling_map: {error}")
        self._chance = Random(self.config.seed)
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Take a picture."""
        sample = self.pose.read_newest()
        if sample is None:
            return RTC_OK
        config = self.config
        view = View(
            config.width, config.height, config.Center_X, config.Center_Y, config.pixel
        )
        image = picture(self._lamps, pose_of(sample.data), view)
        for _ in range(config.noise):
            image[self._chance.randrange(len(image))] = BRIGHT
        self.CameraData.write(rtc.TimedOctetSeq(sample.tm, bytes(image)))
        return RTC_OK
