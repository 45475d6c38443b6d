/** What the data around a point say of it: where they draw it, how far off it is, how it faces
 *  (lop/project.h, whose formulas these are). Data are gathered first, so that what each one says
 * is computed in vectors. */
#ifndef VOR_LOP_DRAWN_H
#define VOR_LOP_DRAWN_H

/** Most data that count. */
enum { VOR_LOP_DATA_MOST = 64 };

/** Data, a lane each. */
struct vor_lop_data {
    unsigned count;
    float there[3][VOR_LOP_DATA_MOST];  /**< from the point to the datum */
    float normal[3][VOR_LOP_DATA_MOST]; /**< read only if the point has a normal */
    float area[VOR_LOP_DATA_MOST];      /**< around the datum, as the density says it; > 0 */
};

/** How data count. */
struct vor_lop_counting {
    double along2;  /**< reach, squared, for where the point is drawn to */
    double across2; /**< the same for its height and normal */
    double scale;   /**< vor_lop_scale of sigma_n (lop/weights.h) */
    double nearest; /**< distance, squared and over the area of a datum, below which none comes
                         nearer */
};

/** Sums over the data. */
struct vor_lop_drawn {
    double to[3], alpha;   /**< from the point, times alpha; alpha */
    double height, weight; /**< of the point's side along its normal, times weight; weight */
    double normal[3];      /**< of the point's side, times weight */
    double density;        /**< the sum of 1 / area */
};

/** Adds up what the data say of a point.
 *
 *  @param[in] normal  of the point, a unit vector; or NULL: data of all sides count, and height,
 *                     weight and normal are 0
 *
 *  O(count). The same bits on every machine. */
void vor_lop_drawn_by(struct vor_lop_drawn *out, const struct vor_lop_data *data,
                      const float *normal, const struct vor_lop_counting *how);

#endif
