"""CeilingNavigation: the pose of the base by the lamps in a picture of the ceiling."""

from __future__ import annotations

from refnav.ceiling import View, blobs, fitted, in_body, parse, recognised
from refnav.map_text import MapError, text_of
from refnav.messages import pose_message
from refnav.pose_history import PoseHistory
from refrobots import iis
from refrobots.components.ceiling_navigation import CeilingNavigationBase
from rtgen.runtime import RTC_OK, ReturnCode_t

CENTIMETRE = 0.01
SPECK = 4
"""Spots of fewer pixels are mistakes of the camera."""


class CeilingNavigation(CeilingNavigationBase):
    """Tells where the base was when a picture was taken, if two lamps or more are recognised."""

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Load the map of the ceiling."""
        name = self.config.NavigationMap
        try:
            self._lamps = parse(text_of(self.folder, name), name)
        except MapError as error:
            return self.fail(f"NavigationMap: {error}")
        self._about = PoseHistory()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Look at the newest picture."""
        port = self.LocalizedPosition
        while port.is_new() and (about := port.read()) is not None:
            self._about.add(about)
        sample = self.CameraData.read_newest()
        if sample is None or not self._about:
            return RTC_OK
        config = self.config
        if len(sample.data) % config.ImageWidth:
            return self.fail(
                f"CameraData: {len(sample.data)} pixels are no rows of {config.ImageWidth}"
            )
        view = View(
            config.ImageWidth,
            len(sample.data) // config.ImageWidth,
            config.Center_X,
            config.Center_Y,
            config.RealMapSize * CENTIMETRE / config.VirtualMapSize,
        )
        seen = [
            in_body(blob, view)
            for blob in blobs(sample.data, view, config.BlackWhiteValue)
            if blob.pixels >= SPECK and blob.coefficient >= config.BlockCoefficient
        ]
        about_then = self._about.at(sample.tm)
        pose = fitted(recognised(seen, self._lamps, about_then, config.SearchScope))
        if pose is not None:
            found = iis.TimedPose2D(sample.tm, [], pose_message(pose), [])
            self.CeilingPosition.write(found)
        return RTC_OK
