"""UcodeSettlement: the records of ucodes, with a cache. Also for the small runtime."""

from refnav.recent import Recent, entries, octets_of
from refrobots import ucode
from refrobots.components.ucode_settlement import UcodeSettlementBase
from rtgen.runtime import RTC_OK, ReturnCode_t


class UcodeSettlement(UcodeSettlementBase):
    """Sends the record of the nearest marker for each reading; the server answers with a delay.

    Its observable `asked` counts the requests.
    """

    def on_initialize(self) -> ReturnCode_t:
        """Publish the number of requests."""
        self._asked = 0
        self.observables["asked"] = lambda: (float(self._asked),)
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        """Start with an empty cache."""
        self._asked = 0
        self._records: dict[bytes, str] = {}
        for words in entries(self.config.records):
            self._records[octets_of(words[0])] = " ".join(words[1:])
        self._cache = Recent(self.config.cache)
        self._texts = [""] * self.config.cache
        self._record = ucode.TimedRecord()
        self._waiting = 0
        return RTC_OK

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        """Wait for the server, or look up the newest reading."""
        if self._waiting > 0:
            self._waiting -= 1
            if self._waiting == 0:
                self._take_record()
            return RTC_OK
        reading = self.sightings.read_newest()
        if reading is None or len(reading.data) == 0:
            return RTC_OK
        nearest = reading.data[0]
        record = self._record
        record.tm.sec = reading.tm.sec
        record.tm.nsec = reading.tm.nsec
        record.code = nearest.code
        record.distance = nearest.distance
        record.bearing = nearest.bearing
        place = self._cache.find(nearest.code)
        if place >= 0:
            record.cached = True
            self._send(self._texts[place])
        else:
            record.cached = False
            self._asked += 1
            self._waiting = self.config.delay
            if self._waiting == 0:
                self._take_record()
        return RTC_OK

    def _take_record(self) -> None:
        text = self._records.get(self._record.code, "")
        self._texts[self._cache.take(self._record.code)] = text
        self._send(text)

    def _send(self, text: str) -> None:
        self._record.known = text != ""
        self._record.record = text
        self.record.write(self._record)
