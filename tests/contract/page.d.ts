/* three.js of Debian has no types. */
declare module 'three';
declare module 'orbit-controls';
