from rtgen.runtime import RTC_OK, Component


class Fan(Component):
    def on_execute(self, ec_id):
        self.speed = 100 / self.time_constant
        return RTC_OK
