#!/usr/bin/perl
# What invariants 1 and 6 of ARCHITECTURE.md say of core, read off its objects: no clock, environment, file, socket or printing,
# nothing static that changes, and no transcendental function of libm on the way to a result.
use strict;
use warnings;
use File::Basename qw(dirname);
use Test::More;

my $build = dirname($ENV{VORONOID} // 'build/release/voronoid');
my @objects = split /\n/, `find $build/core -name '*.o'`;
ok(@objects > 100, 'the objects of core are there') or BAIL_OUT('build first');

# All that core takes from elsewhere. What it calls beside these is looked at before it is added here.
my %known = map { $_ => 1 } qw(
    memcpy memmove memset memcmp memchr strlen strcmp strncmp strstr strchr strspn strcspn strpbrk strtod snprintf vsnprintf qsort
    malloc calloc aligned_alloc free fmax fmin fmaxf fminf ldexp frexp floor
    __assert_fail __stack_chk_fail _GLOBAL_OFFSET_TABLE_ __cpu_indicator_init __cpu_model __cpu_features2 __popcountdi2
    pthread_create pthread_join pthread_mutex_init pthread_mutex_lock pthread_mutex_unlock pthread_mutex_destroy
    pthread_cond_init pthread_cond_wait pthread_cond_signal pthread_cond_broadcast pthread_cond_destroy);
# One door each: FLANN, and two figures of a report that no result hangs on.
my %door = (
    (map { $_ => 'knn/knn_flann' } qw(flann_build_index_float flann_find_nearest_neighbors_index_float flann_free_index_float)),
    acos  => 'mesh/describe',
    log10 => 'metrics/distortion',
);

sub calls_fault {
    my ($object, $symbol) = @_;
    $symbol =~ s/^__(\w+)_chk$/$1/;
    return '' if $symbol =~ /^vor_/ || $known{$symbol};
    return '' if exists $door{$symbol} && $object eq $door{$symbol};
    return "$object calls $symbol";
}

# A line of `nm -f sysv`: name, value, class, type, size, line, section. Tables of pointers are put in place once, before main.
sub keeps_fault {
    my ($object, $line) = @_;
    my ($name, undef, undef, $type, undef, undef, $section) = map { s/^\s+|\s+$//gr } split /\|/, $line;
    return '' unless defined $section && $type eq 'OBJECT';
    return $section =~ /^\.(?:data|bss|tdata|tbss)(?!\.rel\.ro)|COM/ ? "$object keeps $name" : '';
}

my (@calls, @keeps);
my $object = '';
for my $line (split /\n/, `nm -f sysv @objects`) {
    $object = $1 if $line =~ m{^(?:Undefined symbols|Symbols) from \S*?/core/(\S+)\.o:};
    push @calls, grep { $_ } calls_fault($object, $1) if $line =~ /^(\w+)\s*\|\s*\|\s+U\s/;
    push @keeps, grep { $_ } keeps_fault($object, $line);
}
isnt($object, '', 'nm has named the objects');
is("@calls", '', 'core calls nothing that has a clock, an environment, a file or a libm of its own');
is("@keeps", '', 'core keeps nothing that changes');

isnt(calls_fault('cvt/lloyd', $_), '', "$_ would be found") for qw(time clock_gettime getenv __printf_chk fopen sin exp pow acos);
isnt(keeps_fault('cvt/lloyd', "calls |0|  b  |            OBJECT|4|     |.bss"), '', 'a counter would be found');
isnt(keeps_fault('cvt/lloyd', "calls |0|  d  |            OBJECT|4|     |.data"), '', 'with a first value, too');
done_testing();
