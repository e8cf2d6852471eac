// An RT component of RTC 1.0 over CORBA with one periodic execution context, and its parameters.
#ifndef COMPONENT_HH
#define COMPONENT_HH

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <string>
#include <thread>
#include <vector>

#include "ports.hh"

using Parameters = std::map<std::string, std::string>;

// One set of parameters, `default`, whose values are texts, and sets that describe them.
class Configuration : public POA_SDOPackage::Configuration {
 public:
  explicit Configuration(Parameters parameters) : parameters_(std::move(parameters)) {}
  // The sets `__constraints__`, `__type__` and so on.
  std::map<std::string, Parameters> described;

  double number(const std::string& name);

  // OpenRTM has no operations for single parameters.
  CORBA::Any* get_configuration_parameter_value(const char*) override { return new CORBA::Any; }
  CORBA::Boolean set_configuration_parameter(const char*, const CORBA::Any&) override {
    return true;
  }

  SDOPackage::ConfigurationSetList* get_configuration_sets() override;
  SDOPackage::ConfigurationSet* get_configuration_set(const char* id) override;
  CORBA::Boolean set_configuration_set_values(const SDOPackage::ConfigurationSet& set) override;
  SDOPackage::ConfigurationSet* get_active_configuration_set() override;
  CORBA::Boolean add_configuration_set(const SDOPackage::ConfigurationSet& set) override;
  CORBA::Boolean remove_configuration_set(const char* id) override;
  CORBA::Boolean activate_configuration_set(const char* id) override;

 private:
  std::mutex lock_;
  Parameters parameters_;
};

// The states of the component, and the thread that executes it. A request is carried out by the
// thread, `delay` later; it is answered by RTC_ERROR if that takes more than half a second.
class Context : public POA_RTC::ExecutionContextService {
 public:
  explicit Context(double rate) : rate_(rate) {}
  std::chrono::milliseconds delay{0};
  bool refuses = false;
  void begin(RTC::RTObject_ptr component);
  void end();

  CORBA::Boolean is_running() override { return running_; }
  RTC::ReturnCode_t start() override { return run(true); }
  RTC::ReturnCode_t stop() override { return run(false); }
  CORBA::Double get_rate() override { return rate_; }
  RTC::ReturnCode_t set_rate(CORBA::Double rate) override;
  RTC::ReturnCode_t add_component(RTC::LightweightRTObject_ptr) override {
    return RTC::UNSUPPORTED;
  }
  RTC::ReturnCode_t remove_component(RTC::LightweightRTObject_ptr component) override {
    return is_own(component) ? RTC::UNSUPPORTED : RTC::BAD_PARAMETER;
  }
  RTC::ReturnCode_t activate_component(RTC::LightweightRTObject_ptr component) override;
  RTC::ReturnCode_t deactivate_component(RTC::LightweightRTObject_ptr component) override;
  RTC::ReturnCode_t reset_component(RTC::LightweightRTObject_ptr component) override;
  RTC::LifeCycleState get_component_state(RTC::LightweightRTObject_ptr) override;
  RTC::ExecutionKind get_kind() override { return RTC::PERIODIC; }
  RTC::ExecutionContextProfile* get_profile() override;

  // The callbacks of the component.
  std::function<RTC::ReturnCode_t()> activated, deactivated, execute;

 private:
  using Callback = std::function<RTC::ReturnCode_t()>;
  RTC::ReturnCode_t go(RTC::LifeCycleState from, RTC::LifeCycleState to, const Callback& callback);
  RTC::ReturnCode_t run(bool runs);
  bool is_own(RTC::LightweightRTObject_ptr component);
  void step();

  std::atomic<double> rate_;
  std::atomic<bool> running_{true};
  RTC::RTObject_var component_;
  std::mutex lock_;
  std::condition_variable changed_;
  const Callback* callback_ = nullptr;
  RTC::LifeCycleState wanted_ = RTC::INACTIVE_STATE;
  std::chrono::steady_clock::time_point due_;
  bool waits_ = false;
  RTC::LifeCycleState state_ = RTC::INACTIVE_STATE;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

// What tools and other components see; behaviours derive from it and set the callbacks of `context`.
class Component : public POA_RTC::RTObject {
 public:
  Component(CORBA::ORB_ptr orb, std::string instance, std::string type, Parameters parameters,
            double rate);
  void add(Port& port);

  Context context;
  Configuration configuration;
  std::map<std::string, std::string> properties;

  // RTC::ComponentAction and LightweightRTObject: a component is driven by its own context.
  RTC::ReturnCode_t on_initialize() override { return RTC::UNSUPPORTED; }
  RTC::ReturnCode_t on_finalize() override { return RTC::UNSUPPORTED; }
  RTC::ReturnCode_t on_startup(CORBA::Long) override { return RTC::UNSUPPORTED; }
  RTC::ReturnCode_t on_shutdown(CORBA::Long) override { return RTC::UNSUPPORTED; }
  RTC::ReturnCode_t on_activated(CORBA::Long) override { return RTC::UNSUPPORTED; }
  RTC::ReturnCode_t on_deactivated(CORBA::Long) override { return RTC::UNSUPPORTED; }
  RTC::ReturnCode_t on_aborting(CORBA::Long) override { return RTC::UNSUPPORTED; }
  RTC::ReturnCode_t on_error(CORBA::Long) override { return RTC::UNSUPPORTED; }
  RTC::ReturnCode_t on_reset(CORBA::Long) override { return RTC::UNSUPPORTED; }
  RTC::ReturnCode_t initialize() override { return RTC::PRECONDITION_NOT_MET; }
  RTC::ReturnCode_t finalize() override { return RTC::UNSUPPORTED; }
  RTC::ReturnCode_t exit() override { return RTC::UNSUPPORTED; }
  CORBA::Boolean is_alive(RTC::ExecutionContext_ptr) override { return true; }
  CORBA::Long attach_context(RTC::ExecutionContext_ptr) override { return -1; }
  RTC::ReturnCode_t detach_context(CORBA::Long) override { return RTC::UNSUPPORTED; }
  RTC::ExecutionContext_ptr get_context(CORBA::Long handle) override;
  RTC::ExecutionContextList* get_owned_contexts() override;
  RTC::ExecutionContextList* get_participating_contexts() override;
  CORBA::Long get_context_handle(RTC::ExecutionContext_ptr) override { return 0; }

  RTC::ComponentProfile* get_component_profile() override;
  RTC::PortServiceList* get_ports() override;

  char* get_sdo_id() override { return CORBA::string_dup(instance_.c_str()); }
  char* get_sdo_type() override { return CORBA::string_dup(type_.c_str()); }
  SDOPackage::Configuration_ptr get_configuration() override { return configuration._this(); }

 protected:
  CORBA::ORB_var orb_;

 private:
  std::string instance_, type_;
  std::vector<Port*> ports_;
};

#endif
