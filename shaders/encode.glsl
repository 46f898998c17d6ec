// SPDX-License-Identifier: MIT
// Encoded bytes of four linear values. The including kernel declares kEncoding and encodeTable.
Int encode(Real x) {
    Int code;
    if (kEncoding == kEncodeLinear) {
        code = encodeLinear(x);
    } else if (kEncoding == kEncodeNative) {
        code = encodeNative(x);
    } else {
        Real clamped = clampUnit(x);
        Int bucket = encodeBucket(clamped);
        Int word = Int(texelFetch(encodeTable, bucket.x).x, texelFetch(encodeTable, bucket.y).x, texelFetch(encodeTable, bucket.z).x,
                       texelFetch(encodeTable, bucket.w).x);
        code = encodeInBucket(clamped, word);
    }
    return code;
}
