/* The watch: what it says of each sensor, in `flagged`, and of the whole, in `status`.
 *
 * It tests the innovations of each sensor against the limits of the pen file, as pen-mhe does, and
 * repeated readings. A reading that is stuck or an outlier is not used, nor are those of a sensor
 * that stands out while no other does, until a second of its readings fits again. Where several
 * stand out none is blamed: @{PREFIX}_STATUS_INCONSISTENT, the estimate is not to be used. Livelier
 * is said, and process noise stays as it is. @{PREFIX}_STATUS_LOST is said as long as it holds: begin
 * again with init there, as what is found again without that may be another attitude. A step that
 * leaves something out costs two.
 *
 * What only pen-mhe itself does, as it takes the last seconds again: find which of several sensors
 * is wrong, free a bias that has stepped, begin again by itself, let process noise grow, and mend
 * the estimate for what a sensor spoilt before it was noticed. */
