// SPDX-License-Identifier: MIT
// A way to draw: one folder behind one interface. Which way draws a picture is asked in one table (techniques.cpp) and nowhere else.
#pragma once

#include "host/recorder.h"
#include "pipeline/render/planes.h"
#include "pipeline/render/prepare.h"

#include <cstdint>
#include <memory>
#include <string>

namespace plumb {

class StageCheck;

// A picture that stays on the device from draw to draw. Its PreparedPicture and its device outlive it.
class ResidentPicture {
public:
    virtual ~ResidentPicture() = default;
    // Colour alone, left where the device wrote it. False, and nothing is drawn: the picture needs more than stays in place (samples, several
    // chunks).
    virtual bool draw() = 0;
    virtual ResidentScene::Picture pixels() const = 0;  // of the last draw()
    // Every plane that the request asks for, into `out`. False: it needs more than stays on the device (several chunks).
    virtual bool drawPlanes(Frame& out) = 0;
    // Takes over what PreparedPicture::place() changed. `objects`: their matrices too, not the camera alone.
    virtual void moved(bool objects) = 0;
    virtual RenderCounters counters() const = 0;  // of the last draw() or drawPlanes()
    virtual Recorder& recorder() = 0;
};

// A scene prepared by one way to draw, for one side. The scene outlives it.
class PreparedPicture {
public:
    PreparedPicture(const Scene& scene, const RenderRequest& request, Prepared prepared);
    virtual ~PreparedPicture() = default;
    PreparedPicture(const PreparedPicture&) = delete;
    PreparedPicture& operator=(const PreparedPicture&) = delete;

    const Plan& plan() const { return p_.plan; }
    // Draws by the plan, and closes it. Null: the twin draws. The picture must be prepared for that side.
    RenderResult draw(Device* device);
    // Picture that stays on the device. Null for a technique whose pictures do not.
    virtual std::unique_ptr<ResidentPicture> stay(Device&) { return nullptr; }
    // Prepares anew what depends on the scene's camera and on where its objects stand, and nothing else. False, also after an exception: the
    // picture is not to be drawn any more, and must be prepared as a whole.
    virtual bool place() { return false; }
    // Compares each pass of the device with the twin, on the twin's input. Does nothing for a technique that is one pass.
    virtual void verifyStages(Device&, StageCheck&) {}

protected:
    // Writes the frame, the counters and the times, and states in the plan which steps have nothing to do.
    virtual void draw(Device* device, PlaneWriter& writer, RenderResult& result) = 0;

    const Scene& scene_;
    const RenderRequest request_;
    Prepared p_;
};

// Plane bits of pictures of lines, and those that pictures of surfaces have beside them.
inline constexpr uint32_t kPlanesOfLines = kPlaneColour | kPlaneLinear | kPlaneObject | kPlanePrimitive;
inline constexpr uint32_t kPlanesOfSurfaces = kPlanesSeen & ~uint32_t(kPlaneTriangle);

struct Technique {
    // Arithmetic that moves vertices to the screen: the transform pass, float32 in the lines pass, binary64 on the host, or none for rays.
    enum class Vertices { transformPass, linesPass, host, none };

    const char* name;
    // Throws, one sentence, for each combination that the technique does not have. Needs no device.
    void (*refuse)(const Scene&, const RenderRequest&);
    // Input of its passes, and the plan for the side.
    Prepared (*prepare)(const Scene&, const RenderRequest&, RunsOn side);
    std::unique_ptr<PreparedPicture> (*picture)(const Scene&, const RenderRequest&, Prepared);
    // Part of the scene that only rays show and a picture of this kind leaves out. Empty: nothing.
    std::string (*leavesToRays)(const Scene&);
    uint32_t planes;                  // Plane bits that its pictures have
    Vertices vertices;                // arithmetic of the vertices of the scene's meshes
    bool parallel = false;            // true: parallel projection, in which both eyes see the same
    const char* wholePass = nullptr;  // the one pass that is the whole chain; null: stages are compared one by one, or not at all

    // True when its pictures show surfaces. False for drawings of lines.
    bool showsSurfaces() const { return (planes & kPlanesOfSurfaces) == kPlanesOfSurfaces; }
};

// True when rays draw the picture.
bool isTraced(const RenderRequest& request);
// Technique of a request: the first of the table that draws it.
const Technique& techniqueOf(const Scene& scene, const RenderRequest& request);
// Throws, one sentence, for what no technique has, or not the technique of the request.
void refuse(const Scene& scene, const RenderRequest& request);
// Prepares the picture, or throws as refuse() does. The caller holds a PlainFloats.
std::unique_ptr<PreparedPicture> pictureOf(const Scene& scene, const RenderRequest& request, RunsOn side);
// Draws a scene once. `device` null: the twin draws.
RenderResult render(Device* device, const Scene& scene, const RenderRequest& request);

}  // namespace plumb
