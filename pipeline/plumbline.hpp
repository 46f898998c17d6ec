// SPDX-License-Identifier: MIT
// The library `plumbline`: read a scene, draw it on a device or by the CPU twin (same bytes), compare the two, write the picture.
// Every failure is a plumb::Error that knows the exit code of the command. examples/render_mesh shows the whole of it.
#pragma once

#include "host/device.h"            // Device: what was found, what draws
#include "host/error.h"             // Error
#include "pipeline/image/image.h"   // writeFrame: PNG, EXR, NPY
#include "pipeline/render/render.h" // RenderRequest, planRender, renderCpu, renderGpu, verifyRender
#include "pipeline/scene/load.h"    // loadScene, completeScene
