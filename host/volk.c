// SPDX-License-Identifier: MIT
// The one translation unit that holds volk (the loader is opened at run time; its absence is no crash).
#define VOLK_IMPLEMENTATION
#include <volk.h>
