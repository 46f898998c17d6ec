// SPDX-License-Identifier: MIT
// Ray of a sample's path, its nearest hit, and the surface there (trace.comp).

// The parts of a sample's path share what they know in variables of the file: a struct that goes from function to function by value is more
// words in the module.
// Ray that is followed now.
struct PathRay {
    vec3 o, d;
    float weight;  // share of its colour in the sample's
    uint from;     // object that it starts on, or kNoObject
    bool inside;   // true when it starts on the inner side of that object
    uint depth;    // 1: from the eye
    uint kind;     // kCountPrimary, kCountReflected or kCountRefracted
    uint key;      // of its noise
};
PathRay ray;
RayFrame frame;   // of `ray`, kMeshes
uint undecided;   // planes that are parallel to `ray` within rounding
uint shadowRays;  // shadow rays from the hit of `ray`

// Sample that the rays belong to.
vec3 colour;           // sum so far
vec4 levels[kLevels];  // of each ray: its own part of the colour, the share of what it is followed by
uint rays;             // number that this dispatch has followed
uint waits;            // number that wait in the list
uint primaryBits;      // 1: the eye ray hits something

uint firstTriangle() { return push.sphereCount + push.planeCount; }

// Nearest hit so far of `ray`.
struct Nearest {
    float t;
    uint object;  // kNoObject: none
};
Nearest nearest;
void takeHit(bool nearer, float t, uint object) {
    nearest.t = nearer ? t : nearest.t;
    nearest.object = nearer ? object : nearest.object;
}

void meetSpheres() {
    int i = 0;
    [[unroll]] for (i = 0; i < sphereCount(); ++i) {
        SphereHit met = sphereAt(i, ray.o, ray.d, ray.from, ray.inside);
        takeHit(isNearer(met.t, uint(i), nearest.t, nearest.object), met.t, uint(i));
    }
    fault |= i < sphereCount() ? kFaultLoop : 0u;
}

void meetBoards() {
    int i = 0;
    for (i = 0; i < boardCount(); ++i) {
        PlaneHit met = boardAt(i, ray.o, ray.d, ray.from, ray.inside);
        takeHit(isNearer(met.t, push.sphereCount + uint(i), nearest.t, nearest.object), met.t, push.sphereCount + uint(i));
        undecided += met.undecided;
    }
    fault |= i < boardCount() ? kFaultLoop : 0u;
}

// Returns the next leaf whose box a ray may meet nearer than `longest`, as a link; below kLeaf when the walk is over. `child` is where it goes
// on.
uint nextLeaf(RayFrame along, float longest, inout int child) {
    int children = int(push.childCount);
    uint link = 0u;
    while (child < children && link < kLeaf) {
        uvec4 low = texelFetch(nodes, child * 2);
        uvec4 high = texelFetch(nodes, child * 2 + 1);
        bool open = opensFor(along, low, high, longest);
        link = open ? low.w : 0u;
        child = open && link < kLeaf ? int(link * kNodeChildren) : int(high.w);
    }
    return link;
}

// `eye`: what the eye ray meets, when eye rays have walked the tree together.
void meetMeshes(bool runs, EyeHit eye) {
    int children = int(push.childCount);
    int child = runs ? 0 : children;
    if (kEyeTogether && rays == 1u && push.first != 0u) {
        takeHit(eye.triangle != kNoObject && isNearer(eye.t, firstTriangle() + eye.triangle, nearest.t, nearest.object), eye.t,
                firstTriangle() + eye.triangle);
        child = children;
    }
    if (!kEyeTogether || kChildren || kList) {
        while (child < children) {
            uint link = nextLeaf(frame, nearest.t, child);
            uint triangle;
            TriangleHit met = leafAt(link >= kLeaf ? link & ~kLeaf : 0u, frame, ray.from - firstTriangle(), triangle);
            takeHit(link >= kLeaf && isNearer(met.t, firstTriangle() + triangle, nearest.t, nearest.object), met.t,
                    firstTriangle() + triangle);
        }
        fault |= child < children ? kFaultLoop : 0u;
    }
}

void nearestHit(bool runs, EyeHit eye) {
    nearest = Nearest(kFarthestHit, kNoObject);
    meetSpheres();
    meetBoards();
    if (kMeshes) {
        frame = frameOfRay(ray.o, ray.d, push.reach);
        meetMeshes(runs, eye);
    }
}

// Surface where `ray` hits it.
struct Hit {
    bool any;   // true when the ray hits something
    bool mesh;  // true when that is a triangle of a mesh
    SurfacePoint s;
    uint material;
    bool within;  // true when the ray meets the inner side
    vec3 n;       // normal that faces the ray
    vec3 seen;    // the same for shading: interpolated on a mesh
    vec3 bends;   // the same for mirrored and refracted rays
    vec3 before;  // origin of rays that leave on the ray's side
};
Hit hit;

SurfacePoint pointOfSphere(int sphere, out uint owner) {
    vec4 record = sphereRecordOf(sphere, owner);
    SphereHit again = sphereOf(record, sphere, ray.o, ray.d, ray.from, ray.inside);
    SurfacePoint s = pointOnSphere(record.xyz, record.w, again.offset);
    if (kClose) s = pointOnCloseSphere(ray.o, ray.d, again.t, record.xyz, record.w, powerOf(sphere), again.offset);
    return s;
}

SurfacePoint pointOfMesh(int triangle, out uint owner, out vec3 interpolated) {
    uvec4 words = texelFetch(triangles, triangle * 2);
    TriangleHit again = triangleAt(words, frame, false);
    vec3 geometric = uintBitsToFloat(texelFetch(triangles, triangle * 2 + 1).xyz);
    interpolated =
        unitLength((texelFetch(corners, int(words.x) * 2 + 1).xyz * again.w0 + texelFetch(corners, int(words.y) * 2 + 1).xyz * again.w1) +
                   texelFetch(corners, int(words.z) * 2 + 1).xyz * again.w2);
    owner = words.w;
    return pointOnTriangle(texelFetch(corners, int(words.x) * 2).xyz, texelFetch(corners, int(words.y) * 2).xyz,
                           texelFetch(corners, int(words.z) * 2).xyz, geometric, again);
}

void takeSurface(bool own, SurfacePoint s, uint owner) {
    hit.s.point = own ? s.point : hit.s.point;
    hit.s.normal = own ? s.normal : hit.s.normal;
    hit.s.error = own ? s.error : hit.s.error;
    hit.material = own ? owner : hit.material;
}

// Fills `hit` from the nearest object.
void surfaceOf(bool runs) {
    hit.any = runs && nearest.object != kNoObject;
    hit.mesh = kMeshes && hit.any && nearest.object >= firstTriangle();
    bool ball = nearest.object < push.sphereCount;
    hit.s = SurfacePoint(vec3(0.0), vec3(0.0), vec3(0.0));
    hit.material = 0u;
    if (kBoards != 0) {
        int board = hit.any && !ball && !hit.mesh ? int(nearest.object - push.sphereCount) : 0;
        PlaneHit onBoard = boardAt(board, ray.o, ray.d, ray.from, ray.inside);
        hit.s = pointOnPlane(boardTexel(board, 0).xyz, onBoard.point);
        hit.material = materialOfBoard(board, onBoard);
    }
    uint owner = 0u;
    if (kSpheres != 0) {
        SurfacePoint onSphere = pointOfSphere(ball ? int(nearest.object) : 0, owner);
        takeSurface(ball, onSphere, owner);
    }
    vec3 smoothNormal = hit.s.normal;
    if (kMeshes) {
        vec3 interpolated;
        SurfacePoint onMesh = pointOfMesh(hit.mesh ? int(nearest.object - firstTriangle()) : 0, owner, interpolated);
        takeSurface(hit.mesh, onMesh, owner);
        smoothNormal = hit.mesh ? interpolated : hit.s.normal;
    }
    hit.within = dot3(ray.d, hit.s.normal) > 0.0;
    hit.n = hit.within ? -hit.s.normal : hit.s.normal;
    hit.seen = hit.n;
    hit.bends = hit.n;
    if (kMeshes) {
        hit.seen = hit.mesh ? (hit.within ? -smoothNormal : smoothNormal) : hit.n;
        if (kChildren) hit.bends = hit.mesh ? normalForRays(ray.d, hit.n, hit.seen) : hit.n;
    }
    hit.before = leaveSurface(hit.s.point, hit.n, hit.s.error);
}
