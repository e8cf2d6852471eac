// PositionInput of RH3 in C++: `position_input CORBANAME TYPE [ORB options]`.
//
// Sends a goal at its activation, again until somebody takes it, and prints FINISH when it is reached.
// CORBANAME is where it is bound (corbaname::HOST:PORT#NAME.rtc). TYPE is the type that its OutPort
// declares.
#include <omniORB4/Naming.hh>
#include <intellirobot.hh>

#include <chrono>
#include <csignal>
#include <iostream>

#include "component.hh"

namespace {

constexpr const char* INSTANCE = "PositionInput0";

class PositionInput : public Component {
 public:
  PositionInput(CORBA::ORB_ptr orb, const std::string& type)
      : Component(orb, INSTANCE, "PositionInput",
                  {{"01_x", "0"}, {"01_y", "0"}, {"01_th", "0"}, {"input", "none"}}, 50.0),
        out_(orb, std::string(INSTANCE) + ".positon", "DataOutPort", type),
        in_(orb, std::string(INSTANCE) + ".status", "DataInPort", "IDL:IIS/TimedState:1.0") {
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
    IIS::TimedState state;
    while (in_.read(state))
      if (sent_ && state.data == IIS::FINISH) std::cout << "FINISH" << std::endl;
    return RTC::RTC_OK;
  }

  OutPort out_;
  InPort in_;
  bool sent_ = false, going_ = false;
  std::chrono::steady_clock::time_point begun_;
};

// Binds an object under the name behind # of a corbaname, with its contexts.
void bind(CORBA::ORB_ptr orb, const std::string& address, CORBA::Object_ptr object) {
  const auto mark = address.find('#');
  CORBA::Object_var root = orb->string_to_object(address.substr(0, mark).c_str());
  CosNaming::NamingContext_var context = CosNaming::NamingContext::_narrow(root);
  std::string rest = address.substr(mark + 1);
  while (true) {
    const auto slash = rest.find('/');
    const std::string part = rest.substr(0, slash);
    const auto dot = part.rfind('.');
    CosNaming::Name name;
    name.length(1);
    name[0].id = part.substr(0, dot).c_str();
    name[0].kind = dot == std::string::npos ? "" : part.substr(dot + 1).c_str();
    if (slash == std::string::npos) {
      context->rebind(name, object);
      return;
    }
    CORBA::Object_var below;
    try {
      below = context->bind_new_context(name);
    } catch (const CosNaming::NamingContext::AlreadyBound&) {
      below = context->resolve(name);
    }
    context = CosNaming::NamingContext::_narrow(below);
    rest = rest.substr(slash + 1);
  }
}

}  // namespace

int main(int argc, char** argv) {
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGTERM);
  sigaddset(&ends, SIGINT);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  CORBA::ORB_var orb = CORBA::ORB_init(argc, argv);
  if (argc != 3) {
    std::cerr << "position_input CORBANAME TYPE [ORB options]" << std::endl;
    return 2;
  }
  CORBA::Object_var object = orb->resolve_initial_references("RootPOA");
  PortableServer::POA_var poa = PortableServer::POA::_narrow(object);
  PortableServer::POAManager_var manager = poa->the_POAManager();
  manager->activate();
  PositionInput component(orb, argv[2]);
  RTC::RTObject_var reference = component._this();
  component.context.begin(reference);
  try {
    bind(orb, argv[1], reference);
  } catch (const CORBA::Exception& error) {
    std::cerr << argv[1] << ": " << error._name() << std::endl;
    component.context.end();
    return 1;
  }
  std::cout << "ready" << std::endl;
  int number;
  sigwait(&ends, &number);
  component.context.end();
  orb->shutdown(true);
  return 0;
}
