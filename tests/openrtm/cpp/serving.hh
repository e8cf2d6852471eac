// The process of one component: bound in a naming service until the process is ended.
#ifndef SERVING_HH
#define SERVING_HH

#include <functional>
#include <memory>
#include <string>

#include "component.hh"

using Maker = std::function<std::unique_ptr<Component>(CORBA::ORB_ptr)>;

// Binds the component at a corbaname, prints `ready`, and waits for SIGTERM or SIGINT. Returns the
// exit code.
int serve(CORBA::ORB_ptr orb, const std::string& address, const Maker& maker);

#endif
