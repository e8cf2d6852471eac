#include "serving.hh"

#include <omniORB4/Naming.hh>

#include <csignal>
#include <iostream>

namespace {

// Binds an object under the name behind # of a corbaname, with its contexts.
void bind_at(CORBA::ORB_ptr orb, const std::string& address, CORBA::Object_ptr object) {
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

int serve(CORBA::ORB_ptr orb, const std::string& address, const Maker& maker) {
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGTERM);
  sigaddset(&ends, SIGINT);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  CORBA::Object_var object = orb->resolve_initial_references("RootPOA");
  PortableServer::POA_var poa = PortableServer::POA::_narrow(object);
  PortableServer::POAManager_var manager = poa->the_POAManager();
  manager->activate();
  const std::unique_ptr<Component> component = maker(orb);
  RTC::RTObject_var reference = component->_this();
  component->context.begin(reference);
  try {
    bind_at(orb, address, reference);
  } catch (const CORBA::Exception& error) {
    std::cerr << address << ": " << error._name() << std::endl;
    component->context.end();
    return 1;
  }
  std::cout << "ready" << std::endl;
  int number;
  sigwait(&ends, &number);
  component->context.end();
  orb->shutdown(true);
  return 0;
}
