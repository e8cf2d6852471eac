"""CeilingNavigation: the pose of the base from a picture of the lamps on the ceiling."""

from __future__ import annotations

from refnav.ceiling import View, blobs, fitted, in_body, parse, recognised
from refnav.map_text import MapError, text_of
from refnav.messages import pose_message
from refnav.newest import Newest, all_in_time
from refnav.pose_history import PoseHistory
from refrobots import iis, rtc
from refrobots.components.ceiling_navigation import CeilingNavigationBase
from rtgen.runtime import RTC_OK, ReturnCode_t

CENTIMETRE = 0.01
MIN_PIXELS = 4
"""Spots of fewer pixels are noise."""


class CeilingNavigation(CeilingNavigationBase):
    """Sends the pose of the base at the time of a picture, if two lamps or more are recognised."""

    def on_initialize(self) -> ReturnCode_t:
        """Watch the age of both inputs."""
        config = self.config
        self._position = Newest[iis.TimedPose2D](
            self.LocalizedPosition, lambda: config.PositionTimeout
        )
        self._picture = Newest[rtc.TimedOctetSeq](
            self.CameraData, lambda: config.CameraTimeout
        )
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Load the map of the ceiling."""
        name = self.config.NavigationMap
        try:
            self._lamps = parse(text_of(self.folder, name), name)
        except MapError as error:
            return self.fail(f"NavigationMap: {error}")
        self._position.start(self.now())
        self._picture.start(self.now())
        self._about = PoseHistory()
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Evaluate the newest picture."""
        now = self.now()
        while self.LocalizedPosition.is_new():
            if (about := self._position.read(now)) is not None:
                self._about.add(about)
        sample = self._picture.read_newest(now)
        in_time = all_in_time(self, now, self._position, self._picture)
        if sample is None or not self._about or not in_time:
            return RTC_OK
        config = self.config
        if len(sample.data) % config.ImageWidth:
            return self.fail(
                f"CameraData: {len(sample.data)} pixels are not rows of {config.ImageWidth}"
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
            if blob.pixels >= MIN_PIXELS and blob.coefficient >= config.BlockCoefficient
        ]
        about_then = self._about.at(sample.tm)
        pose = fitted(recognised(seen, self._lamps, about_then, config.SearchScope))
        if pose is not None:
            found = iis.TimedPose2D(sample.tm, [], pose_message(pose), [])
            self.CeilingPosition.write(found)
        return RTC_OK
