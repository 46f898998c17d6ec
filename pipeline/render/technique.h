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
    // Draws by the plan, and closes it. Null: the twin draws. The side is that for which the picture is prepared.
    RenderResult draw(Device* device);
    // None: pictures of this kind do not stay on the device.
    virtual std::unique_ptr<ResidentPicture> stay(Device&) { return nullptr; }
    // Prepares anew what depends on the scene's camera and on where its objects stand, and nothing else. False, also after an exception: the
    // picture is not to be drawn any more, and must be prepared as a whole.
    virtual bool place() { return false; }
    // Compares each pass of the device on the twin's input with the twin, as far as this way to draw has passes to be taken apart.
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
    // The arithmetic that moves vertices to the screen: that of the transform pass, float32 in the lines pass, binary64 on the host, or none at all
    // because rays meet the surfaces.
    enum class Vertices { transformPass, linesPass, host, none };

    const char* name;
    // Throws, one sentence, for each combination that this way to draw does not have. No device is needed.
    void (*refuse)(const Scene&, const RenderRequest&);
    // What its passes take, with the plan of the side.
    Prepared (*prepare)(const Scene&, const RenderRequest&, RunsOn side);
    std::unique_ptr<PreparedPicture> (*picture)(const Scene&, const RenderRequest&, Prepared);
    // What of the scene only rays show and a picture of this kind leaves out. Empty: nothing.
    std::string (*leavesToRays)(const Scene&);
    uint32_t planes;                  // Plane bits that its pictures have
    Vertices vertices;                // of the scene's meshes
    bool parallel = false;            // projection is parallel: both eyes see the same
    const char* wholePass = nullptr;  // the one pass that is the whole chain; null: stages are compared one by one, or not at all

    // False for drawings, whose lines are no picture of a surface.
    bool showsSurfaces() const { return (planes & kPlanesOfSurfaces) == kPlanesOfSurfaces; }
};

// The first of the table that draws the request.
const Technique& techniqueOf(const Scene& scene, const RenderRequest& request);
// Throws, one sentence, for what no way to draw has, or not the one that draws the request.
void refuse(const Scene& scene, const RenderRequest& request);
// Refused or prepared. PlainFloats are the caller's.
std::unique_ptr<PreparedPicture> pictureOf(const Scene& scene, const RenderRequest& request, RunsOn side);
// Null: the twin draws.
RenderResult render(Device* device, const Scene& scene, const RenderRequest& request);

}  // namespace plumb
