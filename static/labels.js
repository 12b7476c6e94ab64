/** Where names and numbers stand beside what they tell of: arithmetic only, in pixels. */

/**
 * Places labels in a column, none over another, each as near as may be to where it points.
 *
 * The least squares of the distances, by merging neighbours that would overlap (R. E. Barlow and
 * H. D. Brunk's pool of adjacent violators, on heights less what stands above).
 *
 * @param {{wanted: number, height: number}[]} labels the middle that each would like, its height
 * @param {number} top
 * @param {number} bottom of the column
 * @param {number} gap between two
 * @returns {number[]} the middle of each; where they are too many they run out at the bottom
 */
export function column(labels, top, bottom, gap = 4) {
  const order = labels.map((_, i) => i).sort((a, b) => labels[a].wanted - labels[b].wanted);
  let above = top;
  const offsets = order.map((i) => {
    const middle = above + labels[i].height / 2;
    above += labels[i].height + gap;
    return middle;
  });
  const room = Math.max(0, bottom - (above - gap));
  const blocks = [];
  order.forEach((i, rank) => {
    blocks.push({ mean: labels[i].wanted - offsets[rank], size: 1 });
    while (blocks.length > 1 && blocks.at(-2).mean >= blocks.at(-1).mean) {
      const [a, b] = blocks.splice(-2);
      const size = a.size + b.size;
      blocks.push({ mean: (a.mean * a.size + b.mean * b.size) / size, size });
    }
  });
  const slack = blocks.flatMap(({ mean, size }) => Array(size).fill(mean));
  const middles = Array(labels.length);
  order.forEach((i, rank) => {
    middles[i] = offsets[rank] + Math.min(Math.max(slack[rank], 0), room);
  });
  return middles;
}

/**
 * Shares labels out to two columns: each to the side that it points to, those that point to the
 * middle to whichever has fewer.
 *
 * @param {number[]} across where each points, from the left
 * @param {number} middle
 * @param {number} near how far from it still counts as the middle
 * @returns {("left"|"right")[]}
 */
export function sides(across, middle, near) {
  const result = across.map((x) =>
    Math.abs(x - middle) <= near ? null : x < middle ? "left" : "right",
  );
  const count = (side) => result.filter((each) => each === side).length;
  result.forEach((side, i) => {
    if (side === null) result[i] = count("left") <= count("right") ? "left" : "right";
  });
  return result;
}
