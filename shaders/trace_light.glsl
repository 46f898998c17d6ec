// SPDX-License-Identifier: MIT
// Local colour of a hit: its material, and the lights as shadow rays find them (trace.comp).

// Material of `hit`.
TraceMaterial material;
void readMaterial() {
    int first = int(hit.material) * kTraceMaterialTexels;
    vec4 base = texelFetch(materials, first);
    vec4 diffuse = texelFetch(materials, first + 1);
    vec4 specular = texelFetch(materials, first + 2);
    vec4 shares = texelFetch(materials, first + 3);
    material = TraceMaterial(base.xyz, base.w, diffuse.xyz, diffuse.w, specular.xyz, specular.w, shares.x, shares.y, shares.z, shares.w);
}

// Dims `passed`, the light that a shadow ray keeps, by what stands between `hit` and the light.
void dimBySpheres(ShadowRay shadowRay, inout float passed) {
    int i = 0;
    [[unroll]] for (i = 0; i < sphereCount(); ++i) {
        SphereHit met = sphereAt(i, hit.before, shadowRay.direction, nearest.object, hit.within);
        passed *= blocks(met.t, shadowRay.reach) ? (kDims ? shareThatPasses(texelFetch(surfaces, i).x) : 0.0) : 1.0;
    }
    fault |= i < sphereCount() ? kFaultLoop : 0u;
}
void dimByBoards(ShadowRay shadowRay, inout float passed) {
    int i = 0;
    for (i = 0; i < boardCount(); ++i) {
        PlaneHit met = boardAt(i, hit.before, shadowRay.direction, nearest.object, hit.within);
        passed *= blocks(met.t, shadowRay.reach) ? (kDims ? shareThatPasses(materialOfBoard(i, met)) : 0.0) : 1.0;
    }
    fault |= i < boardCount() ? kFaultLoop : 0u;
}
void dimByMeshes(ShadowRay shadowRay, bool sent, inout float passed) {
    RayFrame along = frameOfRay(hit.before, shadowRay.direction, push.reach);
    int children = int(push.childCount);
    int child = 0;
    while (sent && passed > 0.0 && child < children) {
        uint link = nextLeaf(along, shadowRay.reach, child);
        uint triangle;
        TriangleHit at = leafAt(link >= kLeaf ? link & ~kLeaf : 0u, along, nearest.object - firstTriangle(), triangle);
        uint owner = texelFetch(triangles, int(triangle) * 2).w;
        float slope = dot3(shadowRay.direction, uintBitsToFloat(texelFetch(triangles, int(triangle) * 2 + 1).xyz));
        bool met = link >= kLeaf && blocks(at.t, shadowRay.reach);
        passed *= met ? passesTriangle(shareThatPasses(owner), slope) : 1.0;
    }
    fault |= sent && passed > 0.0 && child < children ? kFaultLoop : 0u;
}

// Returns the share of a light that reaches `hit`. `lit`: true when the hit asks for this light.
float shareOfLight(int light, vec4 lamp, bool lit) {
    ShadowRay shadowRay = shadowRayTo(lamp, hit.before);
    bool above = dot3(hit.seen, shadowRay.direction) > 0.0 && dot3(hit.n, shadowRay.direction) > 0.0;
    shadowRays += kShadows && lit && above ? 1u : 0u;
    if (kJitterShadow != 0u)
        shadowRay.direction =
            jittered(shadowRay.direction, hit.n, uintBitsToFloat(kJitterShadow), keyOfChild(ray.key, kFirstShadowKey + uint(light)));
    float passed = 1.0;
    if (kShadows) {
        dimBySpheres(shadowRay, passed);
        dimByBoards(shadowRay, passed);
        if (kMeshes) dimByMeshes(shadowRay, lit && above, passed);
    }
    return above ? passed : 0.0;
}

vec4 lightTexel(int light, int k) {
    vec4 texel;
    if (kOneLight)
        texel = heldLight[k];
    else
        texel = texelFetch(lights, light * kLightTexels + k);
    return texel;
}

// Returns the Phong colour of `hit`, each light dimmed by what its shadow ray meets. `local`: true when the hit shows it.
Colour localColour(bool local) {
    Colour c = Colour(material.base.x, material.base.y, material.base.z);
    Surface surface =
        Surface(hit.seen.x, hit.seen.y, hit.seen.z, -ray.d.x, -ray.d.y, -ray.d.z, hit.s.point.x, hit.s.point.y, hit.s.point.z);
    Reflectance k = Reflectance(material.diffuse.x, material.diffuse.y, material.diffuse.z, material.specular.x, material.specular.y,
                                material.specular.z, material.shininess, material.zeroPower);
    ShadeParts parts = ShadeParts(true, kSpecular, kPointLights, kPowerExact);
    int lightCount = int(push.lightCount);
    int light = 0;
    if (kLights) do {
            bool lit = local && light < lightCount;
            if (lit || together()) {
                vec4 lamp = lightTexel(light, 0);
                vec4 intensity = lightTexel(light, 1);
                float passed = shareOfLight(light, lamp, lit);
                addLight(lamp, vec4(intensity.xyz * passed, intensity.w), surface, k, parts, c);
            }
            light++;
        } while (!kOneLight && light < lightCount);
    fault |= kLights && local && light < lightCount ? kFaultLoop : 0u;
    return c;
}

// Adds what `ray` itself sees to the sample.
void addColour(bool runs) {
    bool local = hit.any && material.local > 0.0;
    Colour c = localColour(local);
    float share = ray.weight * material.local;
    vec3 added = vec3(c.r, c.g, c.b) * share;
    added = hit.any ? (local ? added : vec3(0.0)) : push.sky * ray.weight;
    colour = runs ? colour + added : colour;
    if (kCutLevels) {
        vec3 own = hit.any ? wholeLevels(vec3(c.r, c.g, c.b)) * material.local : wholeLevels(push.sky);
        levels[ray.depth - 1u] = vec4(local || !hit.any ? own : vec3(0.0), hit.any ? material.reflect : 0.0);
    }
}
