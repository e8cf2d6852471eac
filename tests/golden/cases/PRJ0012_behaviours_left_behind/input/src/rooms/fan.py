from house.components.fan import FanBase
from house.house import Speed

from rtgen.runtime import RTC_OK, ReturnCode_t


class Fan(FanBase):
    def on_execute(self, ec_id: int) -> ReturnCode_t:
        self.sped.write(Speed(1.0))
        return RTC_OK
