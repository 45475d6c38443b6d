/* Values as a URL has them. */

/** A query of values; blanks are %20, which + is not everywhere. */
export const query = (values) => new URLSearchParams(values).toString().replaceAll('+', '%20');
