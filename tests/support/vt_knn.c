#include "tests/support/vt_knn.h"

#include <assert.h>

void vt_knn_brute(const float *xyz, size_t n, const float *queries, size_t count, unsigned k,
                  uint32_t *index, float *distance2)
{
    assert(k >= 1 && k <= n);
    for (size_t q = 0; q < count; q++, index += k, distance2 += k) {
        unsigned found = 0;

        for (size_t i = 0; i < n; i++) {
            float x = xyz[3 * i] - queries[3 * q], y = xyz[3 * i + 1] - queries[3 * q + 1],
                  z = xyz[3 * i + 2] - queries[3 * q + 2];
            float d = x * x + y * y + z * z;
            unsigned at;

            if (found == k && !(d < distance2[k - 1]))
                continue;
            found += found < k;
            for (at = found - 1; at > 0 && d < distance2[at - 1]; at--) {
                distance2[at] = distance2[at - 1];
                index[at] = index[at - 1];
            }
            distance2[at] = d;
            index[at] = (uint32_t)i;
        }
    }
}
