// Data ports of RTC 1.0 over CORBA, interface type corba_cdr, pushed: what an RT component in C++
// needs of it, written by hand against omniORB. Neither OpenRTM nor rtgen takes part. What follows
// a lost connection is as in OpenRTM-aist 2.1.0.
#ifndef PORTS_HH
#define PORTS_HH

#include <OpenRTM.hh>
#include <RTC.hh>

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

using Connectors = std::map<std::string, RTC::ConnectorProfile>;

std::string text(const SDOPackage::NVList& list, const char* name);
void set(SDOPackage::NVList& list, const char* name, const std::string& value);

// A port: the chain of notify_connect through the ports of a connector (RTC 1.0, 5.4.2.8).
class Port : public POA_RTC::PortService {
 public:
  Port(CORBA::ORB_ptr orb, std::string name, std::string kind, std::string type);

  RTC::PortService_ptr reference();
  RTC::RTObject_var owner;

  RTC::PortProfile* get_port_profile() override;
  RTC::ConnectorProfileList* get_connector_profiles() override;
  RTC::ConnectorProfile* get_connector_profile(const char* id) override;
  RTC::ReturnCode_t connect(RTC::ConnectorProfile& profile) override;
  RTC::ReturnCode_t disconnect(const char* id) override;
  RTC::ReturnCode_t disconnect_all() override;
  RTC::ReturnCode_t notify_connect(RTC::ConnectorProfile& profile) override;
  RTC::ReturnCode_t notify_disconnect(const char* id) override;

 protected:
  // Adds what this port offers to a connector, takes what the others do, and forgets it.
  virtual void offer(RTC::ConnectorProfile& profile) = 0;
  virtual bool accept(const RTC::ConnectorProfile& profile) = 0;
  virtual void drop(const std::string& id) = 0;

  CORBA::ORB_var orb_;
  std::mutex lock_;

 private:
  RTC::PortService_ptr next(const RTC::ConnectorProfile& profile);
  void disconnect_dead();

  std::string name_, kind_, type_;
  Connectors connectors_;
};

// Samples are octets of CDR, little-endian unless the connector says otherwise.
class OutPort : public Port {
 public:
  using Port::Port;

  // Whether every connector has taken the sample, and there is one. Others are disconnected.
  template <class Sample>
  bool write(const Sample& sample) {
    return send([&sample](cdrStream& stream) { sample >>= stream; });
  }

 protected:
  void offer(RTC::ConnectorProfile& profile) override;
  bool accept(const RTC::ConnectorProfile& profile) override;
  void drop(const std::string& id) override;

 private:
  struct Peer {
    OpenRTM::InPortCdr_var reference;
    bool big;
  };
  bool send(const std::function<void(cdrStream&)>& marshal);

  std::map<std::string, Peer> peers_;
};

class InPort : public Port {
 public:
  using Port::Port;

  // Takes a sample if one waits.
  template <class Sample>
  bool read(Sample& sample) {
    return take([&sample](cdrStream& stream) { sample <<= stream; });
  }

 protected:
  void offer(RTC::ConnectorProfile& profile) override;
  bool accept(const RTC::ConnectorProfile& profile) override;
  void drop(const std::string& id) override;

 private:
  class Receiver : public POA_OpenRTM::InPortCdr {
   public:
    Receiver(InPort& port, bool big) : port_(port), big_(big) {}
    OpenRTM::PortStatus put(const OpenRTM::CdrData& data) override;

   private:
    InPort& port_;
    bool big_;
  };
  struct Sample {
    std::vector<CORBA::Octet> octets;
    bool big;
  };
  bool take(const std::function<void(cdrStream&)>& unmarshal);

  std::map<std::string, std::unique_ptr<Receiver>> receivers_;
  std::vector<Sample> waiting_;
};

#endif
