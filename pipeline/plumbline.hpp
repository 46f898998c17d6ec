// SPDX-License-Identifier: MIT
// The library `plumbline`: a scene from memory or from a file, drawn on a device or by the CPU twin (same bytes), compared, written.
// Every failure is a plumb::Error that knows the exit code of the command. docs/library.md is its page, examples/memory its first program.
#pragma once

#include "host/device.h"                  // Device: what was found, what draws
#include "host/error.h"                   // Error
#include "pipeline/image/image.h"         // writeFrame, encodePng, encodeExr, encodeNpy
#include "pipeline/library/open_scene.h"  // openScene, requestFor: a file becomes a scene and a request
#include "pipeline/library/picture.h"     // Picture: planes, counters, plan; save()
#include "pipeline/library/renderer.h"    // Renderer: chooses, opens, falls back
#include "pipeline/render/render.h"       // RenderRequest, ResidentScene, planRender, renderCpu, renderGpu, verifyRender
#include "pipeline/scene/load.h"          // loadScene, completeScene
#include "pipeline/scene/look_at.h"       // lookAt: a camera
#include "pipeline/scene/mesh_arrays.h"   // addMesh, addObject, addMaterial: a scene from memory
