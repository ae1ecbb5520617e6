// Adaptive quadrature of sets by the rules of Gauss and Kronrod, step by step as the kernels have it.
const quadrature = (() => {
    CONSTANTS

    // Places that rise, and marks among them.
    function marked(places, marks) {
        return [...places, ...marks].sort((a, b) => a - b);
    }

    // The area over a stretch, the moment about its center, and by how much both may be off.
    function stretch(set, center, half) {
        const value = set(center);
        let area = KRONROD_MIDDLE * value, other = GAUSS_MIDDLE * value, moment = 0.0, other_moment = 0.0;
        let even = EVEN_MIDDLE * value, odd = 0.0;
        for (let k = 0; k < 7; ++k) {
            const away = half * NODES[k], below = set(center - away), above = set(center + away);
            const both = below + above, apart = (above - below) * NODES[k];
            area += KRONROD[k] * both;
            other += GAUSS[k] * both;
            moment += KRONROD[k] * apart;
            other_moment += GAUSS[k] * apart;
            even += EVEN[k] * both;
            odd += ODD[k] * (above - below);
        }
        const away = half * END;
        const ends = Math.abs(set(center + away) - even - odd) + Math.abs(set(center - away) - even + odd);
        const error = Math.abs(area - other) + Math.abs(moment - other_moment) + BEYOND * ends;
        return [half * area, half * half * moment, half * error];
    }

    // Moment and area of the stretches before the one in which the area comes to a bound, whether none was left too
    // long, the ends of this stretch, and its area: 0 where the area nowhere comes to the bound.
    function summed(set, places, allowed, bound) {
        const last = places.length - 1, ends = new Float64Array(DEEPEST + 1);
        const rounded = ROUNDED * Math.max(Math.abs(places[0]), Math.abs(places[last]));
        let area = 0.0, moment = 0.0, complete = true, left_over = MOST;
        for (let k = 0; k < last; ++k) {
            let left = places[k], top = 0;
            ends[0] = places[k + 1];
            const reserve = left_over - Math.floor(left_over / Math.min(last - k, 4));
            while (top >= 0) {
                const right = ends[top], center = 0.5 * left + 0.5 * right;
                const [own, about, error] = stretch(set, center, 0.5 * (right - left));
                left_over -= 1;
                const size = Math.abs(own);
                const imprecise = error > allowed && error > OF_OWN * size && error * (right - left) > rounded * size
                    && top < DEEPEST && left < center && center < right;
                if (imprecise && left_over > reserve) {
                    top += 1;
                    ends[top] = center;
                } else {
                    complete = complete && !imprecise;
                    if (area + own >= bound) {
                        return [moment, area, complete, left, right, own];
                    }
                    area += own;
                    moment += own * center + about;
                    left = right;
                    top -= 1;
                }
            }
        }
        return [moment, area, complete, places[last], places[last], 0.0];
    }

    // Moment and area, and the error of a stretch up to which it was not halved.
    function integrals(set, places) {
        let rough = 0.0;
        for (let k = 0; k < places.length - 1; ++k) {
            const left = places[k], right = places[k + 1];
            rough += Math.abs(stretch(set, 0.5 * left + 0.5 * right, 0.5 * (right - left))[0]);
        }
        let allowed = OF_ALL * rough, [moment, area, complete] = summed(set, places, allowed, NaN);
        for (let k = 0; k < LOOSER && !complete; ++k) {
            allowed *= LOOSENED;
            [moment, area, complete] = summed(set, places, allowed, NaN);
        }
        return [moment, area, allowed];
    }

    // Up to where a stretch has some area, by Newton's method, held between bounds that close in.
    function within(set, left, right, wanted, whole) {
        if (wanted <= 0.0 || whole <= 0.0) {
            return left;
        }
        if (wanted >= whole) {
            return right;
        }
        let low = left, high = right, place = left + (right - left) * (wanted / whole);
        for (let k = 0; k < STEPS; ++k) {
            const beyond = stretch(set, 0.5 * left + 0.5 * place, 0.5 * (place - left))[0] - wanted;
            if (beyond > 0.0) {
                high = place;
            } else {
                low = place;
            }
            const degree = set(place);
            let following = degree > 0.0 ? place - beyond / degree : high;
            if (!(low < following && following < high)) {
                following = 0.5 * low + 0.5 * high;
            }
            if (Math.abs(following - place) <= NEAR * (right - left)) {
                return following;
            }
            place = following;
        }
        return place;
    }

    return {
        // The first moment about 0, and the area.
        moments: (set, places, marks) => integrals(set, marked(places, marks)),
        // Where the area to the left is half of all, in the middle of a gap; and the area.
        half(set, table, marks) {
            const places = marked(table, marks), [, whole, allowed] = integrals(set, places), wanted = 0.5 * whole;
            const [, area, , left, right, own] = summed(set, places, allowed, (1.0 - SLACK) * wanted);
            const after = summed(set, places, allowed, (1.0 + SLACK) * wanted)[3];
            const found = after > right ? 0.5 * right + 0.5 * after : within(set, left, right, wanted - area, own);
            return [found, whole];
        },
    };
})();
