#include "host/selftest.h"
namespace plumb { SelfTest runSelfTest(Device&) { return {}; } }
