// SPDX-License-Identifier: MIT
// Shading and writing of a block of 4 x 4 pixels, by rows, once it is known what each pixel shows (fill.comp).
// Rows are unrolled where lights are constants, or none are needed; otherwise they go through one loop, each as a copy, because what the driver
// makes of four loops over lights in one kernel is slower to make and to run (decision 71).

const int kCopy = 4;  // the row that a loop works on
Colour unlit[5];
Reflectance reflects[5];
Surface surfaces[5];
Colour shades[5];
vec4 lampPositions[kUnrolledLights], lampIntensities[kUnrolledLights];  // the lights that are constants in number and kind

ShadeParts parts() { return ShadeParts(kDiffuse, kSpecular, kPointLights, kPower); }

// Inputs of coarse shading: lane i holds those of the first drawn pixel of the block's i-th 2 x 2 square. The four pixels are shaded as row 0.
vec4 coarseX, coarseY, coarseNx, coarseNy, coarseNz, coarseWeight;
ivec4 coarseZ, coarseMaterial;

void readLamps() {
    [[unroll]] for (uint i = 0u; i < kUnrolledLights; ++i) {
        if (i < kLightCount) {
            int from = (int(push.firstLight) + int(i)) * kLightTexels;
            lampPositions[i] = vec4(texelFetch(lights, from).xyz, lightIsAPoint(kLightKinds, i));
            lampIntensities[i] = vec4(texelFetch(lights, from + 1).xyz, lightAttenuation(kLightKinds, i));
        }
    }
}

void chooseCoarse() {
    [[unroll]] for (int i = 0; i < 4; ++i) {
        int r = (i >> 1) * 2, l = (i & 1) * 2;
        bool inX = pixel.x + l + 1 < push.frameEnd.x, inY = pixel.y + r + 1 < push.frameEnd.y;  // tiles reach beyond the frame
        int which = firstDrawn(id[r][l] != 0, id[r][l + 1] != 0 && inX, id[r + 1][l] != 0 && inY, id[r + 1][l + 1] != 0 && inX && inY) & 3;
        bool right = (which & 1) != 0, below = which > 1;
        ivec4 zs = ivec4(z[r][l], z[r][l + 1], z[r + 1][l], z[r + 1][l + 1]);
        ivec4 ms = ivec4(material[r][l], material[r][l + 1], material[r + 1][l], material[r + 1][l + 1]);
        vec4 xs = vec4(attributeX[r][l], attributeX[r][l + 1], attributeX[r + 1][l], attributeX[r + 1][l + 1]);
        vec4 ys = vec4(attributeY[r][l], attributeY[r][l + 1], attributeY[r + 1][l], attributeY[r + 1][l + 1]);
        vec4 zn = vec4(attributeZ[r][l], attributeZ[r][l + 1], attributeZ[r + 1][l], attributeZ[r + 1][l + 1]);
        vec4 ws = vec4(weight[r][l], weight[r][l + 1], weight[r + 1][l], weight[r + 1][l + 1]);
        coarseX[i] = float(pixel.x + l + (right ? 1 : 0)) + 0.5;
        coarseY[i] = float(pixel.y + r + (below ? 1 : 0)) + 0.5;
        coarseZ[i] = below ? (right ? zs.w : zs.z) : (right ? zs.y : zs.x);
        coarseMaterial[i] = below ? (right ? ms.w : ms.z) : (right ? ms.y : ms.x);
        coarseNx[i] = below ? (right ? xs.w : xs.z) : (right ? xs.y : xs.x);
        coarseNy[i] = below ? (right ? ys.w : ys.z) : (right ? ys.y : ys.x);
        coarseNz[i] = below ? (right ? zn.w : zn.z) : (right ? zn.y : zn.x);
        coarseWeight[i] = below ? (right ? ws.w : ws.z) : (right ? ws.y : ws.x);
    }
}

// Four squares' pixels, each of a material of its own.
void readCoarseMaterials() {
    mat4 a, d, s;
    [[unroll]] for (int i = 0; i < 4; ++i) {
        int m = kOneMaterial ? 0 : coarseMaterial[i] * kMaterialTexels;
        a[i] = texelFetch(materials, m);
        d[i] = texelFetch(materials, m + 1);
        s[i] = texelFetch(materials, m + 2);
    }
    a = transpose(a);
    d = transpose(d);
    s = transpose(s);
    unlit[0] = Colour(a[0], a[1], a[2]);
    reflects[0] = Reflectance(d[0], d[1], d[2], s[0], s[1], s[2], a[3], d[3]);
}

// What the lights of earlier windows left.
Colour sumBefore(int y) {
    Colour c;
    uint sum = at + uint(y) * push.rowQuads + kSlotSum * push.planeQuads;
    c.r = uintBitsToFloat(planes[sum]);
    c.g = uintBitsToFloat(planes[sum + push.planeQuads]);
    c.b = uintBitsToFloat(planes[sum + 2u * push.planeQuads]);
    if (kCoarse) {  // all four pixels have the sum of the one
        uint lower = sum + 2u * push.rowQuads;
        c.r = vec4(c.r.xz, uintBitsToFloat(planes[lower].xz));
        c.g = vec4(c.g.xz, uintBitsToFloat(planes[lower + push.planeQuads].xz));
        c.b = vec4(c.b.xz, uintBitsToFloat(planes[lower + 2u * push.planeQuads].xz));
    }
    return c;
}

// The unit normal, the way to the eye and the position of a row's pixels; returns what lights are added to.
Colour seeLit(int r, int row, Real x, Real share, ivec4 depth, inout Surface surface) {
    float y = float(pixel.y + row) + 0.5;
    Colour c = unlit[r];
    if ((kPlanes & kFillPlaneSum) != 0u && push.firstLight != 0u) c = sumBefore(row);
    Real rx = kCoarse ? rayAtEach(push.rayOrigin.x, push.rayX.x, push.rayY.x, x, coarseY)
                      : rayAt(push.rayOrigin.x, push.rayX.x, push.rayY.x, x, y);
    Real ry = kCoarse ? rayAtEach(push.rayOrigin.y, push.rayX.y, push.rayY.y, x, coarseY)
                      : rayAt(push.rayOrigin.y, push.rayX.y, push.rayY.y, x, y);
    Real rz = kCoarse ? rayAtEach(push.rayOrigin.z, push.rayX.z, push.rayY.z, x, coarseY)
                      : rayAt(push.rayOrigin.z, push.rayX.z, push.rayY.z, x, y);
    if (kUnitNormals) {
        unitVector(surface.nx, surface.ny, surface.nz);
    } else {
        Real inverse = reciprocal(share);
        surface.nx *= inverse;
        surface.ny *= inverse;
        surface.nz *= inverse;
    }
    surface.px = rx;
    surface.py = ry;
    surface.pz = rz;
    surface.vx = -rx;
    surface.vy = -ry;
    surface.vz = -rz;
    if (kSpecular) seeFrom(kDistantViewer, push.toward, surface);
    if (kPointLights) {
        Real w = reciprocal(realOf(max(depth, ivec4(1)))) * push.near;
        surface.px = rx * w;
        surface.py = ry * w;
        surface.pz = rz * w;
    }
#ifdef PLUMB_VECTORS
    if (kSpecular && !kDistantViewer) {
        surface.vx = towardEye[r].x;
        surface.vy = towardEye[r].y;
        surface.vz = towardEye[r].z;
    }
#endif
    return c;
}

// The colour of row r, or of what lights are added to. kCopy is a copy of row y.
void seeRow(int r, int y) {
    Real x = vec4(float(pixel.x) + 0.5) + vec4(0.0, 1.0, 2.0, 3.0);
    Real share = weight[r];
    ivec4 depth = z[r];
    surfaces[r].nx = attributeX[r];
    surfaces[r].ny = attributeY[r];
    surfaces[r].nz = attributeZ[r];
    if (kCoarse) {
        x = coarseX;
        surfaces[r].nx = coarseNx;
        surfaces[r].ny = coarseNy;
        surfaces[r].nz = coarseNz;
        share = coarseWeight;
        depth = coarseZ;
        if (kShading == kShadingPhong || kShading == kShadingUnlit) readCoarseMaterials();
    }
    if (kShading == kShadingGouraud) {
        Real inverse = reciprocal(share);
        shades[r] = Colour(surfaces[r].nx * inverse, surfaces[r].ny * inverse, surfaces[r].nz * inverse);
    } else if (kShading == kShadingFlat) {
        shades[r] = Colour(surfaces[r].nx, surfaces[r].ny, surfaces[r].nz);
    } else if (kShading == kShadingUnlit) {
        shades[r] = Colour(reflects[r].dr, reflects[r].dg, reflects[r].db);
    } else {
        shades[r] = seeLit(r, y, x, share, depth, surfaces[r]);
    }
}

// To row r the lights that are constants.
void addFewLights(int r) {
#ifdef PLUMB_VECTORS
    [[unroll]] for (uint i = 0u; i < kUnrolledLights; ++i) {
        if (i < kLightCount) {
            if (lampPositions[i].w != 0.0)
                addLightFrom(towardLamp[4u * i + uint(r)], lampIntensities[i], surfaces[r], reflects[r], parts(), shades[r]);
            else
                addLight(lampPositions[i], lampIntensities[i], surfaces[r], reflects[r], parts(), shades[r]);
        }
    }
#else
    [[unroll]] for (uint i = 0u; i < kUnrolledLights; ++i) if (i < kLightCount)
        addLight(lampPositions[i], lampIntensities[i], surfaces[r], reflects[r], parts(), shades[r]);
#endif
}

// To row r the lights of this window; returns a fault.
uint addLights(int r) {
    int light = int(push.firstLight) * kLightTexels;
    int end = light + int(push.lightCount) * kLightTexels;
    if (push.lightCount != 0u) {
        do {
            addLight(texelFetch(lights, light), texelFetch(lights, light + 1), surfaces[r], reflects[r], parts(), shades[r]);
            light += kLightTexels;
        } while (light < end);
    }
    return light < end ? kFaultLoop : 0u;
}

void writePlanes(uint rowAt, int r, Colour c, bvec4 drawn) {
    if ((kWrite & kFillPlaneZ) != 0u && mine) planes[rowAt] = uvec4(z[r]);
    if ((kWrite & kFillPlaneTriangle) != 0u) {
        uint slot = rowAt + kSlotTriangle * push.planeQuads;
        uvec4 behind = kPrior ? planes[slot] : uvec4(kNoTriangle);
        if (mine) planes[slot] = mix(behind, uvec4(source[r]) + push.firstTriangle, drawn);
    }
    if ((kWrite & kFillPlaneLinear) != 0u) {
        uint slot = rowAt + kSlotLinear * push.planeQuads;
        [[unroll]] for (uint i = 0u; i < 3u; ++i) {
            vec4 behind = kPrior ? uintBitsToFloat(planes[slot]) : vec4(push.backgroundLinear[i]);
            vec4 value = i == 0u ? c.r : i == 1u ? c.g : c.b;
            if (mine) planes[slot] = floatBitsToUint(mix(behind, value, drawn));
            slot += push.planeQuads;
        }
    }
    if ((kWrite & kFillPlaneSum) != 0u) {
        uint slot = rowAt + kSlotSum * push.planeQuads;
        if (mine) {
            planes[slot] = floatBitsToUint(c.r);
            planes[slot + push.planeQuads] = floatBitsToUint(c.g);
            planes[slot + 2u * push.planeQuads] = floatBitsToUint(c.b);
        }
    }
    if ((kWrite & kFillPlaneNormal) != 0u) {
        vec4 nx = surfaces[r].nx, ny = surfaces[r].ny, nz = surfaces[r].nz;
        if (kCoarse) {
            nx = attributeX[r];
            ny = attributeY[r];
            nz = attributeZ[r];
            if (!kUnitNormals) {
                vec4 inverse = reciprocal(weight[r]);
                nx *= inverse;
                ny *= inverse;
                nz *= inverse;
            }
        }
        if (kCoarse || !kUnitNormals) unitVector(nx, ny, nz);
        uint slot = rowAt + kSlotNormal * push.planeQuads;
        [[unroll]] for (uint i = 0u; i < 3u; ++i) {
            vec4 behind = kPrior ? uintBitsToFloat(planes[slot]) : vec4(0.0);
            vec4 value = i == 0u ? nx : i == 1u ? ny : nz;
            if (mine) planes[slot] = floatBitsToUint(mix(behind, value, drawn));
            slot += push.planeQuads;
        }
    }
}

// Each pixel of row r once: encoded, and the planes asked for. kCopy is a copy of row y.
void writeRow(int r, int y) {
    Colour c = shades[kCoarse ? 0 : r];
    if (kCoarse) c = r < 2 ? Colour(c.r.xxyy, c.g.xxyy, c.b.xxyy) : Colour(c.r.zzww, c.g.zzww, c.b.zzww);
    bvec4 drawn = notEqual(id[r], ivec4(0));
    uint rowAt = at + uint(y) * push.rowQuads;
    if (kColour) {
        uvec4 word = uvec4(encode(c.r) | (encode(c.g) << 8) | (encode(c.b) << 16)) | 0xff000000u;
        uvec4 behind = kPrior ? colours[rowAt] : uvec4(push.background);
        if (mine) colours[rowAt] = mix(behind, word, drawn);
    }
    if (kWrite != 0u) writePlanes(rowAt, r, c, drawn);
}

vec4 rowOf(vec4 a, vec4 b, vec4 c, vec4 d, int y) { return mix(mix(d, c, bvec4(y < 3)), mix(b, a, bvec4(y < 1)), bvec4(y < 2)); }
ivec4 rowOf(ivec4 a, ivec4 b, ivec4 c, ivec4 d, int y) { return mix(mix(d, c, bvec4(y < 3)), mix(b, a, bvec4(y < 1)), bvec4(y < 2)); }

void copyRow(int y) {
    z[kCopy] = rowOf(z[0], z[1], z[2], z[3], y);
    id[kCopy] = rowOf(id[0], id[1], id[2], id[3], y);
    source[kCopy] = rowOf(source[0], source[1], source[2], source[3], y);
    attributeX[kCopy] = rowOf(attributeX[0], attributeX[1], attributeX[2], attributeX[3], y);
    attributeY[kCopy] = rowOf(attributeY[0], attributeY[1], attributeY[2], attributeY[3], y);
    attributeZ[kCopy] = rowOf(attributeZ[0], attributeZ[1], attributeZ[2], attributeZ[3], y);
    weight[kCopy] = rowOf(weight[0], weight[1], weight[2], weight[3], y);
    unlit[kCopy].r = rowOf(unlit[0].r, unlit[1].r, unlit[2].r, unlit[3].r, y);
    unlit[kCopy].g = rowOf(unlit[0].g, unlit[1].g, unlit[2].g, unlit[3].g, y);
    unlit[kCopy].b = rowOf(unlit[0].b, unlit[1].b, unlit[2].b, unlit[3].b, y);
    reflects[kCopy].dr = rowOf(reflects[0].dr, reflects[1].dr, reflects[2].dr, reflects[3].dr, y);
    reflects[kCopy].dg = rowOf(reflects[0].dg, reflects[1].dg, reflects[2].dg, reflects[3].dg, y);
    reflects[kCopy].db = rowOf(reflects[0].db, reflects[1].db, reflects[2].db, reflects[3].db, y);
    reflects[kCopy].sr = rowOf(reflects[0].sr, reflects[1].sr, reflects[2].sr, reflects[3].sr, y);
    reflects[kCopy].sg = rowOf(reflects[0].sg, reflects[1].sg, reflects[2].sg, reflects[3].sg, y);
    reflects[kCopy].sb = rowOf(reflects[0].sb, reflects[1].sb, reflects[2].sb, reflects[3].sb, y);
    reflects[kCopy].n = rowOf(reflects[0].n, reflects[1].n, reflects[2].n, reflects[3].n, y);
    reflects[kCopy].zeroPower = rowOf(reflects[0].zeroPower, reflects[1].zeroPower, reflects[2].zeroPower, reflects[3].zeroPower, y);
}

// Shades the block and writes each pixel once. Call when id, z and attributes of its pixels are complete. Returns fault bits.
uint shadeAndWrite() {
    uint fault = 0u;
    const bool loops = kShading == kShadingPhong && kLightCount == 0u;
    if (kCoarse) chooseCoarse();
    if (loops && !kCoarse) {
        int y = 0;
        do {
            copyRow(y);
            seeRow(kCopy, y);
            fault |= addLights(kCopy);
            writeRow(kCopy, y);
            ++y;
        } while (y < 4);
    } else {
#ifndef PLUMB_VECTORS
        readLamps();
#endif
        [[unroll]] for (int r = 0; r < 4; ++r) {
            if (!kCoarse || r == 0) {
                seeRow(r, r);
                if (loops)
                    fault |= addLights(r);
                else if (kShading == kShadingPhong)
                    addFewLights(r);
            }
            writeRow(r, r);
        }
    }
    return fault;
}
