// PositionInput of RH3 in C++: `position_input CORBANAME TYPE [ORB options]`.
//
// Sends a goal at its activation, again until somebody takes it, and prints FINISH when it is reached.
// CORBANAME is where it is bound (corbaname::HOST:PORT#NAME.rtc). TYPE is the type that its OutPort
// declares.
#include <intellirobot.hh>

#include <chrono>
#include <iostream>

#include "serving.hh"

namespace {

constexpr const char* INSTANCE = "PositionInput0";

class PositionInput : public Component {
 public:
  PositionInput(CORBA::ORB_ptr orb, const std::string& type)
      : Component(orb, INSTANCE, "PositionInput",
                  {{"01_x", "0"}, {"01_y", "0"}, {"01_th", "0"}, {"input", "none"}}, 50.0),
        out_(orb, std::string(INSTANCE) + ".positon", "DataOutPort", type),
        in_(orb, std::string(INSTANCE) + ".status", "DataInPort", "IDL:RTC/TimedState:1.0") {
    add(out_);
    add(in_);
    context.activated = [this] {
      sent_ = going_ = false;
      return RTC::RTC_OK;
    };
    context.execute = [this] { return step(); };
  }

 private:
  RTC::ReturnCode_t step() {
    const auto now = std::chrono::steady_clock::now();
    if (!sent_) {
      IIS::TimedPose2D goal;
      goal.tm.sec = goal.tm.nsec = 0;
      goal.data.position.x = configuration.number("01_x");
      goal.data.position.y = configuration.number("01_y");
      goal.data.heading = configuration.number("01_th");
      sent_ = out_.write(goal);
      begun_ = now;
    } else if (!going_ && now - begun_ > std::chrono::seconds(2)) {
      going_ = true;
      std::cout << "going" << std::endl;
    }
    RTC::TimedState state;
    while (in_.read(state))
      if (sent_ && state.data == IIS::FINISH) std::cout << "FINISH" << std::endl;
    return RTC::RTC_OK;
  }

  OutPort out_;
  InPort in_;
  bool sent_ = false, going_ = false;
  std::chrono::steady_clock::time_point begun_;
};

}  // namespace

int main(int argc, char** argv) {
  CORBA::ORB_var orb = CORBA::ORB_init(argc, argv);
  if (argc != 3) {
    std::cerr << "position_input CORBANAME TYPE [ORB options]" << std::endl;
    return 2;
  }
  const std::string type = argv[2];
  return serve(orb, argv[1], [type](CORBA::ORB_ptr running) {
    return std::make_unique<PositionInput>(running, type);
  });
}
