// A device: `device CORBANAME NAME=VALUE... [ORB options]`.
//
// Its InPort `command` and OutPort `measured` have samples of RTC::TimedDoubleSeq. While ACTIVE it
// prints each command, and sends a sample of `size` numbers at each step, if that is not 0. Arguments: `instance`, `rate` [Hz], `delay`
// of requests [ms], `type` that its ports declare, `activity` of its profile, `refuses` activation.
#include <BasicDataType.hh>

#include <cstdlib>
#include <iostream>

#include "serving.hh"

namespace {

class Device : public Component {
 public:
  Device(CORBA::ORB_ptr orb, const Parameters& options)
      : Component(orb, options.at("instance"), "Device",
                  {{"size", "0"}, {"big", "3"}, {"after", "1000000"}, {"label", ""}},
                  std::strtod(options.at("rate").c_str(), nullptr)),
        out_(orb, options.at("instance") + ".measured", "DataOutPort", options.at("type")),
        in_(orb, options.at("instance") + ".command", "DataInPort", options.at("type")) {
    context.delay = std::chrono::milliseconds(std::atoi(options.at("delay").c_str()));
    configuration.described["__constraints__"] = {{"size", "0<=x<=1000"}};
    configuration.described["__type__"] = {{"size", "long"}, {"label", "string"}};
    properties["activity_type"] = options.at("activity");
    context.refuses = options.at("refuses") == "1";
    add(out_);
    add(in_);
    context.activated = [this] {
      tell("activated");
      sent_ = 0;
      return RTC::RTC_OK;
    };
    context.deactivated = [this] {
      tell("deactivated");
      return RTC::RTC_OK;
    };
    context.execute = [this] { return step(); };
  }

 private:
  // Prints an event with the time of the monotonic clock [s].
  void tell(const char* what) {
    const std::chrono::duration<double> now = std::chrono::steady_clock::now().time_since_epoch();
    std::cout << what << " at " << std::fixed << now.count() << std::endl;
  }

  RTC::ReturnCode_t step() {
    const bool is_big = ++sent_ == static_cast<long>(configuration.number("after"));
    const double size = configuration.number(is_big ? "big" : "size");
    if (size > 0) send(size);
    if (is_big) std::cout << "big" << std::endl;
    RTC::TimedDoubleSeq command;
    while (in_.read(command))
      std::cout << "command of " << command.data.length() << std::endl;
    return RTC::RTC_OK;
  }

  void send(double size) {
    RTC::TimedDoubleSeq sample;
    sample.tm.sec = sample.tm.nsec = 0;
    sample.data.length(static_cast<CORBA::ULong>(size));
    for (CORBA::ULong i = 0; i < sample.data.length(); ++i) sample.data[i] = sent_;
    out_.write(sample);
  }

  OutPort out_;
  InPort in_;
  long sent_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  CORBA::ORB_var orb = CORBA::ORB_init(argc, argv);
  Parameters options{{"instance", "Device0"},
                     {"rate", "50"},
                     {"delay", "0"},
                     {"activity", "PERIODIC"},
                     {"refuses", "0"},
                     {"type", "IDL:RTC/TimedDoubleSeq:1.0"}};
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    const auto sign = word.find('=');
    if (sign == std::string::npos || !options.count(word.substr(0, sign))) {
      std::cerr << word << " is not NAME=VALUE of an option" << std::endl;
      return 2;
    }
    options[word.substr(0, sign)] = word.substr(sign + 1);
  }
  if (argc < 2) return 2;
  return serve(orb, argv[1], [options](CORBA::ORB_ptr running) {
    return std::make_unique<Device>(running, options);
  });
}
