// A driver may end a loop after 65536 rounds; a round of a thousand steps is long all the same.
#define TEN(s) s s s s s s s s s s

void dust(float x, out float result)
{
    result = x;
    for (int i = 0; i < 60000; ++i)
        for (int j = 0; j < 60000; ++j)
        {
            TEN(TEN(TEN(result = sin(result + 1.0);)))
        }
}
