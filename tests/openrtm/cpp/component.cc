#include "component.hh"

#include <chrono>
#include <cstdlib>
#include <iostream>

double Configuration::number(const std::string& name) {
  std::lock_guard<std::mutex> held(lock_);
  return std::strtod(parameters_.at(name).c_str(), nullptr);
}

SDOPackage::ConfigurationSet* Configuration::get_active_configuration_set() {
  std::lock_guard<std::mutex> held(lock_);
  SDOPackage::ConfigurationSet_var made = new SDOPackage::ConfigurationSet;
  made->id = "default";
  made->description = "";
  for (const auto& each : parameters_)
    set(made->configuration_data, each.first.c_str(), each.second);
  return made._retn();
}

SDOPackage::ConfigurationSetList* Configuration::get_configuration_sets() {
  SDOPackage::ConfigurationSet_var active = get_active_configuration_set();
  SDOPackage::ConfigurationSetList_var list = new SDOPackage::ConfigurationSetList;
  list->length(1 + described.size());
  list[0] = active.in();
  CORBA::ULong i = 1;
  for (const auto& each : described) {
    list[i].id = each.first.c_str();
    list[i].description = "";
    for (const auto& pair : each.second)
      set(list[i].configuration_data, pair.first.c_str(), pair.second);
    ++i;
  }
  return list._retn();
}

SDOPackage::ConfigurationSet* Configuration::get_configuration_set(const char* id) {
  SDOPackage::ConfigurationSetList_var list = get_configuration_sets();
  for (CORBA::ULong i = 0; i < list->length(); ++i)
    if (std::string(list[i].id) == id) return new SDOPackage::ConfigurationSet(list[i]);
  throw SDOPackage::InternalError(id);
}

CORBA::Boolean Configuration::set_configuration_set_values(
    const SDOPackage::ConfigurationSet& given) {
  if (std::string(given.id) != "default") throw SDOPackage::InvalidParameter(given.id);
  std::lock_guard<std::mutex> held(lock_);
  for (CORBA::ULong i = 0; i < given.configuration_data.length(); ++i) {
    const SDOPackage::NameValue& item = given.configuration_data[i];
    auto known = parameters_.find(std::string(item.name));
    const char* value;
    if (known == parameters_.end() || !(item.value >>= value))
      throw SDOPackage::InvalidParameter(item.name);
    known->second = value;
  }
  return true;
}

CORBA::Boolean Configuration::add_configuration_set(const SDOPackage::ConfigurationSet& given) {
  throw SDOPackage::InvalidParameter(given.id);
}

CORBA::Boolean Configuration::remove_configuration_set(const char* id) {
  throw SDOPackage::InvalidParameter(id);
}

CORBA::Boolean Configuration::activate_configuration_set(const char* id) {
  if (std::string(id) != "default") throw SDOPackage::InvalidParameter(id);
  return true;
}

void Context::begin(RTC::RTObject_ptr component) {
  component_ = RTC::RTObject::_duplicate(component);
  thread_ = std::thread([this] {
    while (!ends_) {
      if (running_) step();
      std::this_thread::sleep_for(std::chrono::duration<double>(1.0 / rate_));
    }
  });
}

RTC::ReturnCode_t Context::run(bool runs) {
  return running_.exchange(runs) == runs ? RTC::PRECONDITION_NOT_MET : RTC::RTC_OK;
}

RTC::ReturnCode_t Context::set_rate(CORBA::Double rate) {
  if (!(rate > 0)) return RTC::BAD_PARAMETER;
  rate_ = rate;
  return RTC::RTC_OK;
}

bool Context::is_own(RTC::LightweightRTObject_ptr component) {
  return component_->_is_equivalent(component);
}

void Context::step() {
  std::lock_guard<std::mutex> held(lock_);
  if (waits_ && std::chrono::steady_clock::now() >= due_) {
    const bool done = !callback_ || !*callback_ || (*callback_)() == RTC::RTC_OK;
    state_ = done ? wanted_ : RTC::ERROR_STATE;
    waits_ = false;
    changed_.notify_all();
  }
  if (state_ == RTC::ACTIVE_STATE && execute() != RTC::RTC_OK) state_ = RTC::ERROR_STATE;
}

void Context::end() {
  ends_ = true;
  thread_.join();
}

RTC::ReturnCode_t Context::go(RTC::LifeCycleState from, RTC::LifeCycleState to,
                              const Callback& callback) {
  std::unique_lock<std::mutex> held(lock_);
  if (state_ != from) return RTC::PRECONDITION_NOT_MET;
  if (!waits_) {
    waits_ = true;
    wanted_ = to;
    callback_ = &callback;
    due_ = std::chrono::steady_clock::now() + delay;
  }
  const auto patience = std::chrono::milliseconds(500);
  return changed_.wait_for(held, patience, [this] { return !waits_; }) ? RTC::RTC_OK
                                                                       : RTC::RTC_ERROR;
}

RTC::ReturnCode_t Context::activate_component(RTC::LightweightRTObject_ptr component) {
  if (!is_own(component)) return RTC::BAD_PARAMETER;
  if (refuses) return RTC::UNSUPPORTED;
  return go(RTC::INACTIVE_STATE, RTC::ACTIVE_STATE, activated);
}

RTC::ReturnCode_t Context::deactivate_component(RTC::LightweightRTObject_ptr component) {
  if (!is_own(component)) return RTC::BAD_PARAMETER;
  return go(RTC::ACTIVE_STATE, RTC::INACTIVE_STATE, deactivated);
}

RTC::ReturnCode_t Context::reset_component(RTC::LightweightRTObject_ptr component) {
  if (!is_own(component)) return RTC::BAD_PARAMETER;
  static const Callback nothing;
  return go(RTC::ERROR_STATE, RTC::INACTIVE_STATE, nothing);
}

RTC::LifeCycleState Context::get_component_state(RTC::LightweightRTObject_ptr) {
  std::lock_guard<std::mutex> held(lock_);
  return state_;
}

RTC::ExecutionContextProfile* Context::get_profile() {
  RTC::ExecutionContextProfile_var profile = new RTC::ExecutionContextProfile;
  profile->kind = RTC::PERIODIC;
  profile->rate = rate_;
  profile->owner = component_;
  return profile._retn();
}

Component::Component(CORBA::ORB_ptr orb, std::string instance, std::string type,
                     Parameters parameters, double rate)
    : context(rate),
      configuration(std::move(parameters)),
      orb_(CORBA::ORB::_duplicate(orb)),
      instance_(std::move(instance)),
      type_(std::move(type)) {}

void Component::add(Port& port) {
  port.owner = _this();
  ports_.push_back(&port);
}

RTC::ExecutionContext_ptr Component::get_context(CORBA::Long handle) {
  if (handle != 0) return RTC::ExecutionContext::_nil();
  RTC::ExecutionContextService_var service = context._this();
  return RTC::ExecutionContext::_duplicate(service);
}

RTC::ExecutionContextList* Component::get_owned_contexts() {
  RTC::ExecutionContextList_var list = new RTC::ExecutionContextList;
  list->length(1);
  list[0] = get_context(0);
  return list._retn();
}

RTC::ExecutionContextList* Component::get_participating_contexts() {
  return new RTC::ExecutionContextList;
}

RTC::ComponentProfile* Component::get_component_profile() {
  RTC::ComponentProfile_var profile = new RTC::ComponentProfile;
  profile->instance_name = instance_.c_str();
  profile->type_name = type_.c_str();
  profile->description = "by hand in C++";
  profile->version = "1.0.0";
  profile->vendor = "lab";
  profile->category = "lab";
  profile->port_profiles.length(ports_.size());
  for (CORBA::ULong i = 0; i < ports_.size(); ++i) try {
      RTC::PortProfile_var each = ports_[i]->get_port_profile();
      profile->port_profiles[i] = each.in();
    } catch (const CORBA::SystemException&) {
      std::cerr << "get_component_profile has crashed" << std::endl;
      std::abort();  // OpenRTM-aist 2.1.0 returns no profile then, and omniORB reads it.
    }
  set(profile->properties, "language", "C++");
  for (const auto& each : properties)
    set(profile->properties, each.first.c_str(), each.second);
  return profile._retn();
}

RTC::PortServiceList* Component::get_ports() {
  RTC::PortServiceList_var list = new RTC::PortServiceList;
  list->length(ports_.size());
  for (CORBA::ULong i = 0; i < ports_.size(); ++i) list[i] = ports_[i]->reference();
  return list._retn();
}
