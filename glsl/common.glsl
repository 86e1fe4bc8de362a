// What every shader may use.

#include "shared.h"

const float PI = 3.14159265358979323846;

// Unit length; the zero vector stays zero instead of becoming NaN.
vec3 unit(vec3 v) {
    const float smallest_normal = 1.17549435e-38;
    return v * inversesqrt(max(dot(v, v), smallest_normal));
}
