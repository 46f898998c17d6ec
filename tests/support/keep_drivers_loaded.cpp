// SPDX-License-Identifier: MIT
// Linked into every test under the sanitizers: drivers and layers stay loaded after vkDestroyInstance, so that the
// leak report still knows their names and tests/support/lsan.supp can tell their leaks from ours.
#include <dlfcn.h>
#include <initializer_list>

namespace {
const bool kept = [] {
    for (const char* library : {"libvulkan.so.1", "libvulkan_lvp.so", "libVkLayer_khronos_validation.so"})
        dlopen(library, RTLD_LAZY | RTLD_NODELETE);
    return true;
}();
}  // namespace
