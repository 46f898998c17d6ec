// SPDX-License-Identifier: MIT
// Attributes in the fill kernel: those of the visible triangles at the pixels of a block, and their materials (fill.comp).

// Triangle whose values are taken to the pixels that show it.
struct VisibleTriangle {
    int source;  // triangle of the chunk
    int owner;   // its material, or its face when flat
    Edges e;
    vec3 rho;         // of the edges, in pixels
    vec3 w;           // perspective weights of the corners
    vec3 a0, a1, a2;  // the corners' values times their weights
    vec3 flatColour;
};
VisibleTriangle visible;

void readVisible(uvec4 d) {
    visible.source = int(d.w);
    visible.owner = kOneMaterial && kShading != kShadingFlat ? 0 : int(texelFetch(triangleMaterials, int(d.w)).x);
    visible.rho = vec3(0.0);
    visible.a0 = visible.a1 = visible.a2 = vec3(0.0);
    visible.w = vec3(0.0);
    visible.flatColour = vec3(0.0);
    if (kShading == kShadingFlat) visible.flatColour = texelFetch(attributes, visible.owner).xyz;
    if (kShading >= kShadingGouraud) {
        uvec4 v0 = texelFetch(screen, int(d.x));
        uvec4 v1 = texelFetch(screen, int(d.y));
        uvec4 v2 = texelFetch(screen, int(d.z));
        edgesAt(centre, ivec2(v0.xy), ivec2(v1.xy), ivec2(v2.xy), visible.e);
        visible.rho = vec3(visible.e.rho) * 0.00390625;
        visible.w = vec3(uintBitsToFloat(v0.z), uintBitsToFloat(v1.z), uintBitsToFloat(v2.z)) *
                    weightScale(max(max(int(v0.z), int(v1.z)), int(v2.z)));
        if (kAffine) visible.w = vec3(1.0);
        visible.a0 = texelFetch(attributes, int(d.x)).xyz * visible.w.x;
        visible.a1 = texelFetch(attributes, int(d.y)).xyz * visible.w.y;
        visible.a2 = texelFetch(attributes, int(d.z)).xyz * visible.w.z;
    }
}

// Values g_i = E_i / 256 of a row's pixels.
vec4 edgeOne(int r) { return edgeReal(visible.e.hi.x, visible.e.lo.x, visible.e.a.x, visible.e.b.x, r) + visible.rho.x; }
vec4 edgeTwo(int r) { return edgeReal(visible.e.hi.y, visible.e.lo.y, visible.e.a.y, visible.e.b.y, r) + visible.rho.y; }
vec4 edgeThree(int r) { return edgeReal(visible.e.hi.z, visible.e.lo.z, visible.e.a.z, visible.e.b.z, r) + visible.rho.z; }

// Takes the triangle's values into those pixels of row r that show it.
void interpolateRow(int r, bvec4 here) {
    if (kShading == kShadingFlat) {
        attributeX[r] = mix(attributeX[r], vec4(visible.flatColour.x), here);
        attributeY[r] = mix(attributeY[r], vec4(visible.flatColour.y), here);
        attributeZ[r] = mix(attributeZ[r], vec4(visible.flatColour.z), here);
    }
    if (kShading >= kShadingGouraud) {
        vec4 g0 = edgeOne(r);
        vec4 g1 = edgeTwo(r);
        vec4 g2 = edgeThree(r);
        attributeX[r] = mix(attributeX[r], weigh(visible.a0.x, visible.a1.x, visible.a2.x, g0, g1, g2), here);
        attributeY[r] = mix(attributeY[r], weigh(visible.a0.y, visible.a1.y, visible.a2.y, g0, g1, g2), here);
        attributeZ[r] = mix(attributeZ[r], weigh(visible.a0.z, visible.a1.z, visible.a2.z, g0, g1, g2), here);
        if (kShading == kShadingGouraud || !kUnitNormals)
            weight[r] = mix(weight[r], weigh(visible.w.x, visible.w.y, visible.w.z, g0, g1, g2), here);
    }
    source[r] = mix(source[r], ivec4(visible.source), here);
    material[r] = mix(material[r], ivec4(visible.owner), here);
}

#ifdef PLUMB_VECTORS
// Directions to the eye and to each light from a triangle: from its face's centre, or corners in components 0 to 2.
Toward eyeHere;
Toward lampsHere[kUnrolledLights];

void seeTriangle(uvec4 d) {
    vec4 face = texelFetch(triangleCentres, int(d.w));
    Position position = Position(vec4(face.x), vec4(face.y), vec4(face.z));
    if (kVectors == kVectorsVertex) {
        uvec4 c0 = texelFetch(screen, int(d.x));
        uvec4 c1 = texelFetch(screen, int(d.y));
        uvec4 c2 = texelFetch(screen, int(d.z));
        position = positionOfCorner(ivec4(c0.x, c1.x, c2.x, c2.x), ivec4(c0.y, c1.y, c2.y, c2.y),
                                    uintBitsToFloat(uvec4(c0.z, c1.z, c2.z, c2.z)), push.near, push.rayOrigin, push.rayX, push.rayY);
    }
    eyeHere = eyeFrom(position);
    [[unroll]] for (uint i = 0u; i < kUnrolledLights; ++i) if (i < kLightCount) lampsHere[i] =
        lampFrom(lampPositions[i], lampIntensities[i].w, position);
}

void interpolateVectors(int r, bvec4 here) {
    Shares shares = sharesOf(visible.w.x, visible.w.y, visible.w.z, edgeOne(r), edgeTwo(r), edgeThree(r));
    if (kSpecular) interpolateVector(towardEye[r], eyeHere, shares, here);
    [[unroll]] for (uint i = 0u; i < kUnrolledLights; ++i) if (i < kLightCount && lampPositions[i].w != 0.0)
        interpolateVector(towardLamp[4u * i + uint(r)], lampsHere[i], shares, here);
}
#endif

void clearAttributes() {
    [[unroll]] for (int r = 0; r < 4; ++r) {
        attributeX[r] = attributeY[r] = attributeZ[r] = vec4(0.0);
        weight[r] = vec4(1.0);
        source[r] = ivec4(0);
        material[r] = ivec4(-1);
    }
#ifdef PLUMB_VECTORS
    readLamps();
    [[unroll]] for (uint i = 0u; i < kUnrolledLights; ++i) {
        [[unroll]] for (uint r = 0u; r < 4u; ++r) {
            towardEye[r] = Toward(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
            towardLamp[4u * i + r] = towardEye[r];
        }
    }
#endif
}

// Interpolates the attributes of the visible triangles at the 16 pixels: one round for each distinct triangle, from the highest down.
void interpolateVisible(int alone) {
    clearAttributes();
    ivec4 highestId = max(max(id[0], id[1]), max(id[2], id[3]));
    int current = kOne ? alone + 1 : max(max(highestId.x, highestId.y), max(highestId.z, highestId.w));
    int rounds = 0;
    do {
        uvec4 d = texelFetch(draws, max(current - 1, 0));
        readVisible(d);
#ifdef PLUMB_VECTORS
        seeTriangle(d);
#endif
        ivec4 below = ivec4(0);
        [[unroll]] for (int r = 0; r < 4; ++r) {
            bvec4 here = kOne ? bvec4(true) : equal(id[r], ivec4(current));  // alone: its attributes beside its own pixels are not drawn
            interpolateRow(r, here);
#ifdef PLUMB_VECTORS
            interpolateVectors(r, here);
#endif
            below = max(below, mix(ivec4(0), id[r], lessThan(id[r], ivec4(current))));
        }
        current = max(max(below.x, below.y), max(below.z, below.w));
        rounds++;
    } while (!kOne && current != 0 && rounds < 17);
}

// Reads what the materials are made of: one round for each distinct material, and most blocks have one.
void readMaterials() {
    ivec4 highest = max(max(material[0], material[1]), max(material[2], material[3]));
    int current = kOneMaterial ? 0 : max(max(highest.x, highest.y), max(highest.z, highest.w));
    int rounds = 0;
    do {
        int m = max(current, 0) * kMaterialTexels;
        vec4 a = texelFetch(materials, m);
        vec4 d = texelFetch(materials, m + 1);
        vec4 s = texelFetch(materials, m + 2);
        ivec4 below = ivec4(-1);
        [[unroll]] for (int r = 0; r < 4; ++r) {
            bvec4 here = kOneMaterial ? bvec4(true) : equal(material[r], ivec4(current));
            unlit[r] = Colour(mix(unlit[r].r, vec4(a.x), here), mix(unlit[r].g, vec4(a.y), here), mix(unlit[r].b, vec4(a.z), here));
            Reflectance k = reflects[r];
            reflects[r] = Reflectance(mix(k.dr, vec4(d.x), here), mix(k.dg, vec4(d.y), here), mix(k.db, vec4(d.z), here),
                                      mix(k.sr, vec4(s.x), here), mix(k.sg, vec4(s.y), here), mix(k.sb, vec4(s.z), here),
                                      mix(k.n, vec4(a.w), here), mix(k.zeroPower, vec4(d.w), here));
            below = max(below, mix(ivec4(-1), material[r], lessThan(material[r], ivec4(current))));
        }
        current = max(max(below.x, below.y), max(below.z, below.w));
        rounds++;
    } while (!kOneMaterial && !kOne && current >= 0 && rounds < 17);
}
