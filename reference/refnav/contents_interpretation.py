"""ContentsInterpretation: the contents of the records of ucodes. Also for the small runtime."""

from refnav.recent import Recent
from refrobots import ucode
from refrobots.components.contents_interpretation import ContentsInterpretationBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class ContentsInterpretation(ContentsInterpretationBase):
    """Sends the contents of each record that can be interpreted.

    Its observable `interpreted` counts the records that were not in the cache.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Publish the number of interpreted records."""
        self._interpreted = 0
        self.observables["interpreted"] = lambda: (float(self._interpreted),)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start with an empty cache."""
        self._interpreted = 0
        self._cache = Recent(self.config.cache)
        self._contents = [ucode.TimedContents() for _ in range(self.config.cache)]
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Interpret the received records."""
        while self.record.is_new():
            record = self.record.read()
            if record is None or not record.known:
                continue
            place = self._cache.find(record.code)
            if place < 0:
                place = self._cache.take(record.code)
                if not _understand(record.record, self._contents[place]):
                    return self.fail(
                        "record: " + record.record + " is not X Y KIND NAME"
                    )
                self._interpreted += 1
            contents = self._contents[place]
            contents.code = record.code
            contents.tm.sec = record.tm.sec
            contents.tm.nsec = record.tm.nsec
            contents.distance = record.distance
            self.contents.write(contents)
        return RTC_OK


def _understand(text: str, contents: ucode.TimedContents) -> bool:
    words = text.split()
    if len(words) < 4:
        return False
    try:
        contents.position.x = float(words[0])
        contents.position.y = float(words[1])
    except ValueError:
        return False
    contents.kind = words[2]
    contents.name = " ".join(words[3:])
    return True
