from rtgen.runtime import RTC_OK, Component
from rtgen.runtime.library import rtc


class Fan(Component):
    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        self.turns = self.add_out_port("turns", rtc.TimedShort)
        self.count = 32_760

    def on_execute(self, ec_id):
        self.count += 1
        self.turns.write(rtc.TimedShort(data=self.count))
        return RTC_OK
