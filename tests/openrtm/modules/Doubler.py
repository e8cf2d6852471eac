"""A module as written by an author of OpenRTM components, for tests with processes."""

import sys

import OpenRTM_aist
import RTC

doubler_spec = [
    *("implementation_id", "Doubler", "type_name", "Doubler", "category", "Test"),
    *("description", "Multiplies", "version", "1.0.0", "vendor", "tests"),
    *("activity_type", "STATIC", "max_instance", "0"),
    *("language", "Python", "lang_type", "SCRIPT"),
    *("exec_cxt.periodic.rate", "7"),
    *("conf.default.factor", "2"),
    "",
]


class Doubler(OpenRTM_aist.DataFlowComponentBase):
    """A component that writes `factor` times the sample read."""

    def __init__(self, manager):
        OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
        self._d_in = RTC.TimedLong(RTC.Time(0, 0), 0)
        self._inIn = OpenRTM_aist.InPort("in", self._d_in)
        self._d_out = RTC.TimedLong(RTC.Time(0, 0), 0)
        self._outOut = OpenRTM_aist.OutPort("out", self._d_out)
        self._factor = [2]

    def onInitialize(self):
        self.bindParameter("factor", self._factor, "2")
        self.addInPort("in", self._inIn)
        self.addOutPort("out", self._outOut)
        return RTC.RTC_OK

    def onExecute(self, ec_id):
        while self._inIn.isNew():
            self._d_out.data = self._factor[0] * self._inIn.read().data
            self._outOut.write()
        return RTC.RTC_OK


def DoublerInit(manager):
    profile = OpenRTM_aist.Properties(defaults_str=doubler_spec)
    manager.registerFactory(profile, Doubler, OpenRTM_aist.Delete)


def MyModuleInit(manager):
    DoublerInit(manager)
    manager.createComponent("Doubler")


def main():
    manager = OpenRTM_aist.Manager.init(sys.argv)
    manager.setModuleInitProc(MyModuleInit)
    manager.activateManager()
    manager.runManager()


if __name__ == "__main__":
    main()
