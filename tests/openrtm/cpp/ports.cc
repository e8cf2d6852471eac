#include "ports.hh"

#include <algorithm>
#include <utility>

namespace {

constexpr const char* IN_IOR = "dataport.corba_cdr.inport_ior";
constexpr std::size_t LENGTH = 64;

bool is_big(const RTC::ConnectorProfile& profile) {
  return text(profile.properties, "dataport.serializer.cdr.endian").rfind("big", 0) == 0;
}

}  // namespace

std::string text(const SDOPackage::NVList& list, const char* name) {
  for (CORBA::ULong i = 0; i < list.length(); ++i) {
    const char* found;
    if (std::string(list[i].name) == name && (list[i].value >>= found)) return found;
  }
  return "";
}

void set(SDOPackage::NVList& list, const char* name, const std::string& value) {
  CORBA::ULong i = 0;
  while (i < list.length() && std::string(list[i].name) != name) ++i;
  if (i == list.length()) list.length(i + 1);
  list[i].name = name;
  list[i].value <<= value.c_str();
}

Port::Port(CORBA::ORB_ptr orb, std::string name, std::string kind, std::string type)
    : orb_(CORBA::ORB::_duplicate(orb)),
      name_(std::move(name)),
      kind_(std::move(kind)),
      type_(std::move(type)) {}

RTC::PortService_ptr Port::reference() { return _this(); }

// Ends the connections to ended processes. The first call to each fails by COMM_FAILURE, and the
// second one by an exception that leaves this function.
void Port::disconnect_dead() {
  RTC::ConnectorProfileList_var list = get_connector_profiles();
  std::vector<std::string> dead;
  for (CORBA::ULong i = 0; i < list->length(); ++i)
    for (CORBA::ULong k = 0; k < list[i].ports.length(); ++k) {
      bool ended = false;
      try {
        ended = list[i].ports[k]->_non_existent();
      } catch (const CORBA::COMM_FAILURE&) {
        ended = list[i].ports[k]->_non_existent();
      } catch (const CORBA::SystemException&) {
        ended = true;
      }
      if (ended) dead.emplace_back(list[i].connector_id);
    }
  for (const auto& id : dead) disconnect(id.c_str());
}

RTC::PortProfile* Port::get_port_profile() {
  disconnect_dead();
  RTC::PortProfile_var profile = new RTC::PortProfile;
  profile->name = name_.c_str();
  profile->port_ref = reference();
  profile->owner = owner;
  RTC::ConnectorProfileList_var connectors = get_connector_profiles();
  profile->connector_profiles = connectors.in();
  set(profile->properties, "port.port_type", kind_);
  set(profile->properties, "dataport.data_type", type_);
  set(profile->properties, "dataport.dataflow_type", "push");
  set(profile->properties, "dataport.interface_type", "corba_cdr");
  set(profile->properties, "dataport.subscription_type", "flush");
  return profile._retn();
}

RTC::ConnectorProfileList* Port::get_connector_profiles() {
  std::lock_guard<std::mutex> held(lock_);
  RTC::ConnectorProfileList_var list = new RTC::ConnectorProfileList;
  list->length(connectors_.size());
  CORBA::ULong i = 0;
  for (const auto& each : connectors_) list[i++] = each.second;
  return list._retn();
}

RTC::ConnectorProfile* Port::get_connector_profile(const char* id) {
  std::lock_guard<std::mutex> held(lock_);
  auto found = connectors_.find(id);
  return found == connectors_.end() ? new RTC::ConnectorProfile
                                    : new RTC::ConnectorProfile(found->second);
}

RTC::ReturnCode_t Port::connect(RTC::ConnectorProfile& profile) {
  if (profile.ports.length() == 0 || std::string(profile.connector_id).empty())
    return RTC::BAD_PARAMETER;
  return profile.ports[0]->notify_connect(profile);
}

RTC::ReturnCode_t Port::disconnect(const char* id) {
  RTC::ConnectorProfile_var profile = get_connector_profile(id);
  if (profile->ports.length() == 0) return RTC::BAD_PARAMETER;
  for (CORBA::ULong i = 0; i < profile->ports.length(); ++i) try {
      return profile->ports[i]->notify_disconnect(id);
    } catch (const CORBA::SystemException&) {
    }
  return RTC::RTC_ERROR;
}

RTC::ReturnCode_t Port::disconnect_all() {
  RTC::ConnectorProfileList_var list = get_connector_profiles();
  for (CORBA::ULong i = 0; i < list->length(); ++i) disconnect(list[i].connector_id);
  return RTC::RTC_OK;
}

RTC::ReturnCode_t Port::notify_connect(RTC::ConnectorProfile& profile) {
  const std::string id(profile.connector_id);
  if (text(profile.properties, "dataport.interface_type") != "corba_cdr") return RTC::BAD_PARAMETER;
  offer(profile);
  RTC::PortService_var following = next(profile);
  RTC::ReturnCode_t code = RTC::RTC_OK;
  if (!CORBA::is_nil(following)) code = following->notify_connect(profile);
  if (code == RTC::RTC_OK && !accept(profile)) code = RTC::BAD_PARAMETER;
  std::lock_guard<std::mutex> held(lock_);
  if (code == RTC::RTC_OK)
    connectors_[id] = profile;
  else
    drop(id);
  return code;
}

RTC::ReturnCode_t Port::notify_disconnect(const char* id) {
  RTC::ConnectorProfile_var profile = get_connector_profile(id);
  if (profile->ports.length() == 0) return RTC::BAD_PARAMETER;
  {
    std::lock_guard<std::mutex> held(lock_);
    connectors_.erase(id);
    drop(id);
  }
  RTC::PortService_var following = next(profile);
  if (CORBA::is_nil(following)) return RTC::RTC_OK;
  try {
    return following->notify_disconnect(id);
  } catch (const CORBA::SystemException&) {
    return RTC::RTC_ERROR;
  }
}

// The port behind this one in the chain; nil if this is the last.
RTC::PortService_ptr Port::next(const RTC::ConnectorProfile& profile) {
  RTC::PortService_var own = reference();
  for (CORBA::ULong i = 0; i + 1 < profile.ports.length(); ++i)
    if (profile.ports[i]->_is_equivalent(own))
      return RTC::PortService::_duplicate(profile.ports[i + 1]);
  return RTC::PortService::_nil();
}

void OutPort::offer(RTC::ConnectorProfile&) {}

bool OutPort::accept(const RTC::ConnectorProfile& profile) {
  const std::string ior = text(profile.properties, IN_IOR);
  if (ior.empty()) return false;
  CORBA::Object_var object = orb_->string_to_object(ior.c_str());
  Peer peer{OpenRTM::InPortCdr::_unchecked_narrow(object), is_big(profile)};
  std::lock_guard<std::mutex> held(lock_);
  peers_[std::string(profile.connector_id)] = peer;
  return true;
}

void OutPort::drop(const std::string& id) { peers_.erase(id); }

bool OutPort::send(const std::function<void(cdrStream&)>& marshal) {
  std::map<std::string, Peer> peers;
  {
    std::lock_guard<std::mutex> held(lock_);
    peers = peers_;
  }
  bool taken = !peers.empty();
  std::vector<std::string> lost;
  for (auto& each : peers) {
    cdrMemoryStream stream;
    stream.setByteSwapFlag(!each.second.big);
    marshal(stream);
    auto* octets = static_cast<CORBA::Octet*>(stream.bufPtr());
    const OpenRTM::CdrData data(stream.bufSize(), stream.bufSize(), octets, false);
    try {
      taken = each.second.reference->put(data) == OpenRTM::PORT_OK && taken;
    } catch (const CORBA::SystemException&) {
      lost.push_back(each.first);
      taken = false;
    }
  }
  for (const auto& id : lost) disconnect(id.c_str());
  return taken;
}

void InPort::offer(RTC::ConnectorProfile& profile) {
  const std::string id(profile.connector_id);
  std::lock_guard<std::mutex> held(lock_);
  auto& receiver = receivers_[id];
  receiver = std::make_unique<Receiver>(*this, is_big(profile));
  OpenRTM::InPortCdr_var reference = receiver->_this();
  CORBA::String_var ior = orb_->object_to_string(reference);
  set(profile.properties, IN_IOR, ior.in());
}

bool InPort::accept(const RTC::ConnectorProfile&) { return true; }

void InPort::drop(const std::string& id) {
  auto found = receivers_.find(id);
  if (found == receivers_.end()) return;
  // A call that comes in may still be in it, so it stays; its object is gone.
  Receiver* receiver = found->second.release();
  receivers_.erase(found);
  PortableServer::POA_var poa = receiver->_default_POA();
  PortableServer::ObjectId_var object = poa->servant_to_id(receiver);
  receiver->_remove_ref();
  poa->deactivate_object(object);
}

OpenRTM::PortStatus InPort::Receiver::put(const OpenRTM::CdrData& data) {
  std::lock_guard<std::mutex> held(port_.lock_);
  if (port_.waiting_.size() >= LENGTH) return OpenRTM::BUFFER_FULL;
  const CORBA::Octet* begin = data.get_buffer();
  port_.waiting_.push_back({{begin, begin + data.length()}, big_});
  return OpenRTM::PORT_OK;
}

bool InPort::take(const std::function<void(cdrStream&)>& unmarshal) {
  Sample sample;
  {
    std::lock_guard<std::mutex> held(lock_);
    if (waiting_.empty()) return false;
    sample = std::move(waiting_.front());
    waiting_.erase(waiting_.begin());
  }
  cdrMemoryStream stream(sample.octets.data(), sample.octets.size());
  stream.setByteSwapFlag(!sample.big);
  try {
    unmarshal(stream);
  } catch (const CORBA::MARSHAL&) {
    return false;
  }
  return true;
}
