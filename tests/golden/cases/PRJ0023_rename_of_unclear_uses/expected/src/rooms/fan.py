from house.components.fan import FanBase
from house.house import Screw, Speed

from rtgen.runtime import RTC_OK, ReturnCode_t


def double(value):
    return 2 * value.turns


def triple(value):
    return 3 * value.turns


class Fan(FanBase):
    def on_execute(self, ec_id: int) -> ReturnCode_t:
        screw = self.screw.read() or Screw(turns=3)
        self.speed.write(Speed(rounds=double(screw) + screw.turns))
        double(Speed(rounds=0.5))
        return RTC_OK
