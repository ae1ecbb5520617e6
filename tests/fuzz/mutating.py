"""What befalls texts that somebody edits: tokens are lost, doubled, swapped, replaced, copied and cut off."""


def mutated(rng, tokens, words, count):
    """Change a list of tokens.

    Args:
        rng: A random.Random.
        tokens: What a text is made of.
        words: What tokens are replaced by.
        count: How many changes.

    Returns:
        The tokens that are left.
    """
    tokens = list(tokens)
    for _ in range(count):
        if not tokens:
            break
        i, j = rng.randrange(len(tokens)), rng.randrange(len(tokens))
        match rng.randrange(7):
            case 0:
                del tokens[i]
            case 1:
                tokens.insert(i, tokens[j])
            case 2:
                tokens[i], tokens[j] = tokens[j], tokens[i]
            case 3:
                tokens[i] = rng.choice(words)
            case 4:
                del tokens[min(i, j) : min(i, j) + rng.randrange(40)]
            case 5:
                tokens[i:i] = tokens[j : j + rng.randrange(60)]
            case 6:
                del tokens[i:]
    return tokens
